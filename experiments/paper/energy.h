// What a delivered message costs the radios of robots and brokers: airtime and energy.
#pragma once

#include "experiments/paper/paper_plan.h"
#include "experiments/report/section.h"

namespace romano::experiments {

/// A CC2538 at 3 V and 25 °C, with its CPU idle (Texas Instruments, data sheet SWRS096,
/// "Features"): TX is at 0 dBm.
struct Transceiver {
    double volts = 3;
    double receiving_a = 0.020;
    double transmitting_a = 0.024;
};

/// Of one radio, over a time in which it sent for `sending_s`: it listens for the rest of it.
[[nodiscard]] double energy_j(const Transceiver& radio, double lasted_s, double sending_s);

/// From the runs of the paper's table, so it takes no further ones.
[[nodiscard]] Section energy_section(const PaperPlan& plan, const std::filesystem::path& folder);

}  // namespace romano::experiments
