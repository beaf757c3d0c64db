// How much more than one cell many cells carry: which runs, and what they say.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "experiments/process/separate_runs.h"
#include "experiments/report/section.h"

namespace romano::experiments {

struct CellsPlan {
    std::vector<std::size_t> brokers{1, 2, 3, 4, 8, 16, 64};
    std::vector<double> rates{100, 200, 300, 400, 500, 1000, 2000};
    std::size_t channels = 16;
    std::size_t messages = 5'000;
    std::uint64_t seed = 1;
};

[[nodiscard]] std::vector<SeparateRun> runs_of(const CellsPlan& plan);
/// When all runs are done.
[[nodiscard]] Section cells_section(const CellsPlan& plan, const std::filesystem::path& folder);

}  // namespace romano::experiments
