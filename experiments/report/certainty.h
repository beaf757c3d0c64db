// How far the runs of a configuration leave its figures open, and how many more it would take.
#pragma once

#include <span>

#include "experiments/report/configuration.h"
#include "experiments/report/summary_table.h"

namespace romano::experiments {

/// Mean, its 95 % interval and the runs for an interval of 10 % to either side, of the delay (99 %)
/// and the failover. A line a configuration with two runs or more.
/// Of the first `most` configurations that were run several times.
[[nodiscard]] SummaryTable certainty_of(std::span<const Configuration> configurations,
                                        std::size_t most);

}  // namespace romano::experiments
