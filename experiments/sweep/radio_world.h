// A simulated cell whose robots are on IEEE 802.15.4: each broker has a border router, the routers
// stand in a square grid, and a broker's robots around its router (overlay/radio).
#pragma once

#include <memory>
#include <vector>

#include "experiments/sweep/cell_world.h"
#include "experiments/sweep/sweep_file.h"

namespace romano::experiments {

/// Throws SweepError for what cannot be: a channel, a baud, too many robots around a router, or a
/// build without ns-3.
void check_radio(const SweepSettings& settings, const std::vector<Cell>& cells);

[[nodiscard]] std::unique_ptr<CellWorld> make_radio_world(const SweepSettings& settings,
                                                          const Cell& cell);

}  // namespace romano::experiments
