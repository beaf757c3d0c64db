// Real brokers as processes and robots on real sockets, as process_world.h has them, with the
// modelled channel between the two in real time (air/radio_bridge.h): each broker has a border
// router, and its robots talk to that.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "experiments/sweep/cell_world.h"
#include "experiments/sweep/sweep_file.h"

namespace romano::experiments {

/// Throws SweepError for what cannot be, or a build without ns-3.
void check_air(const SweepSettings& settings, const std::vector<Cell>& cells);

/// `network` is the sweep's own, such as "127.50". Throws RunFailed.
[[nodiscard]] std::unique_ptr<CellWorld> make_air_world(const SweepSettings& settings,
                                                        const Cell& cell,
                                                        const std::string& network,
                                                        const std::filesystem::path& program);

}  // namespace romano::experiments
