// Beyond the paper: what robots on the radio notice when their broker dies, when its machine dies
// together with the border router, and when they drive into another broker's cell.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "experiments/process/separate_runs.h"
#include "experiments/report/section.h"

namespace romano::experiments {

enum class Change { none, broker_dies, machine_dies, robots_leave };
inline constexpr std::array all_changes{Change::none, Change::broker_dies, Change::machine_dies,
                                        Change::robots_leave};

struct MovesRun {
    std::vector<double> silence_ms{};  // of each robot: the longest time without a message
    std::size_t sent_qos0 = 0;
    std::size_t lost_qos0 = 0;
    std::size_t sent_qos1 = 0;
    std::size_t lost_qos1 = 0;
    std::size_t joins = 0;
    std::size_t reconnects = 0;  // CONNECTs beyond the first
};
[[nodiscard]] MovesRun moves_run(Change change, std::uint64_t seed);

struct MovesPlan {
    std::size_t runs = 10;
    std::uint64_t seed = 1;
};
[[nodiscard]] std::vector<SeparateRun> runs_of(const MovesPlan& plan);
/// When all runs are done.
[[nodiscard]] Section moves_section(const MovesPlan& plan, const std::filesystem::path& folder);

}  // namespace romano::experiments
