// Beyond the paper: one datagram for a whole cell (romano/mqttsn/cell.md) beside one for each
// robot, the paper's way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "experiments/process/separate_runs.h"
#include "experiments/report/section.h"
#include "romano/mqttsn/types.h"

namespace romano::experiments {

enum class Way : std::uint8_t { unicast, cell };
[[nodiscard]] std::string_view name_of(Way way);

struct BroadcastPlan {
    std::vector<std::size_t> robots{1, 2, 5, 10, 20, 50};
    std::size_t messages = 20;
    std::uint64_t seed = 1;
};

/// Means over the messages.
struct BroadcastRun {
    double first_ms = 0;  // until one robot has it
    double last_ms = 0;   // until all have it that get it
    double heard = 0;     // share of the robots
    double air_ms = 0;    // of a message, answers and repetitions with it
};
/// Messages to `common`, one in five seconds, so that none waits for another one.
[[nodiscard]] BroadcastRun broadcast_run(std::size_t robots, mqttsn::Qos qos, Way way,
                                         std::size_t messages, std::uint64_t seed);

[[nodiscard]] std::vector<SeparateRun> runs_of(const BroadcastPlan& plan);
/// When all runs are done.
[[nodiscard]] Section broadcast_section(const BroadcastPlan& plan,
                                        const std::filesystem::path& folder);

}  // namespace romano::experiments
