// How much delay the pendulum's loop bears at each period and loss: by theory, and as found by
// letting poles stand or fall on the simulator.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "experiments/loops/cart_pole.h"
#include "experiments/process/separate_runs.h"
#include "experiments/report/section.h"

namespace romano::experiments {

struct MarginsPlan {
    std::vector<std::uint16_t> periods_ms{10, 20, 30, 40, 60, 80, 100};
    std::vector<double> losses_percent{0, 10, 30};
    std::size_t poles = 30;  // at each delay, where there are losses; else they are all alike
    double seconds = 20;     // that a pole has to stand
    std::uint64_t seed = 1;
    CartPoleBody body;
};

/// What became of the poles at one delay.
struct Trial {
    double delay_ms = 0;
    std::size_t poles = 0;
    std::size_t stay_up = 0;
    double lost_percent = 0;  // rounds, as the plants counted
};

/// One period and loss.
struct Column {
    std::uint16_t period_ms = 0;
    double loss_percent = 0;
    double mean_square_ms = 0;  // margins by theory
    double usual_ms = 0;
    std::vector<Trial> trials;  // by delay

    /// The least delay at which a pole falls; empty when none does.
    [[nodiscard]] std::optional<double> found_ms() const;
};

/// Tries delays 10 ms apart until all poles fall, and then halves the way between the greatest one
/// up to which all stay up and the next, down to half a millisecond.
[[nodiscard]] Column column_of(const MarginsPlan& plan, std::uint16_t period_ms,
                               double loss_percent);

/// One sentence on what cannot be; empty when all can.
[[nodiscard]] std::optional<std::string> problem_with(const MarginsPlan& plan);
[[nodiscard]] std::vector<SeparateRun> runs_of(const MarginsPlan& plan);
/// When all runs are done.
[[nodiscard]] Section margins_section(const MarginsPlan& plan, const std::filesystem::path& folder);

}  // namespace romano::experiments
