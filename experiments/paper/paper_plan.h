// Which runs `romano paper` does, and the figures that their outcomes give.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "experiments/paper/statements.h"
#include "experiments/process/separate_runs.h"

namespace romano::experiments {

struct PaperPlan {
    std::vector<double> rates{1, 10, 20, 50, 75, 100, 200, 300, 400, 500};
    std::vector<std::uint32_t> router_bauds{115'200, 230'400};
    std::size_t runs = 10;
    std::size_t messages = papers_messages;
    std::size_t delay_messages = 1'000;
    unsigned channel = 26;  // the paper's
    std::uint64_t seed = 1;
};

/// One sentence on what cannot be; empty when all can.
[[nodiscard]] std::optional<std::string> problem_with(const PaperPlan& plan);

[[nodiscard]] std::vector<SeparateRun> runs_of(const PaperPlan& plan);

/// When all runs are done.
[[nodiscard]] std::vector<DeliveryRun> delivery_runs(const PaperPlan& plan, std::uint32_t baud,
                                                     double rate,
                                                     const std::filesystem::path& folder);
[[nodiscard]] FiguresByBaud figures_of(const PaperPlan& plan, const std::filesystem::path& folder);

}  // namespace romano::experiments
