// How far the pole leans when something befalls its loop's broker just as somebody shoves the pole,
// beside the same pole, wind and shove without a fault.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "experiments/loops/cart_pole.h"
#include "experiments/loops/faulty_brokers.h"
#include "experiments/process/separate_runs.h"
#include "experiments/report/section.h"

namespace romano::experiments {

struct DeviationRun {
    /// The greatest angle in the five seconds from the fault on; empty when the pole fell.
    std::optional<double> angle_deg;
    std::uint32_t falls_back = 0;
    double age_ms = 0;       // the greatest of a command in force
    std::uint32_t lost = 0;  // rounds
    /// The longest time from one command to the next; empty when none came within a minute.
    std::optional<double> wait_ms;
    std::vector<double> course_deg;  // the angle, each 20 ms from half a second before the fault
};

struct DeviationCase {
    LoopGround ground{};
    std::size_t brokers = 3;
    BrokerFault fault = BrokerFault::none;
    double shove_rad_s = 0.4;  // how much faster the pole turns at once, one way or the other
    std::uint64_t seed = 1;
};
[[nodiscard]] DeviationRun deviate(const CartPoleBody& body, const DeviationCase& setting);

struct DeviationPlan {
    std::vector<std::size_t> brokers{1, 3, 5};
    std::size_t runs = 100;  // each in its own wind
    double shove_rad_s = 0.4;
    std::uint64_t seed = 1;
    CartPoleBody body;
};

[[nodiscard]] std::vector<SeparateRun> runs_of(const DeviationPlan& plan, const LoopGround& ground);
/// When all runs are done.
[[nodiscard]] Section deviation_section(const DeviationPlan& plan, LoopWorld world,
                                        const std::filesystem::path& folder);

}  // namespace romano::experiments
