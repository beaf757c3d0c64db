// The trade of a failure detector: the shorter the silence that counts as death, the sooner a robot
// has a broker again, and the more often a living broker is taken for dead.
//
// For each detection timeout of a list: trials with a silent broker, then a watch under full load.
#pragma once

#include <functional>

#include "bench/failover/options.h"

namespace romano::bench {

/// Writes trade.csv and trade.svg into the output folder, a table to stdout. False when
/// interrupted.
bool run_trade(const Options& options, const std::function<bool()>& is_over);

}  // namespace romano::bench
