// What a cluster has to look like once it is left alone: P1, P4 and P6.
#pragma once

#include <optional>
#include <string>

#include "overlay/sim/cluster_world.h"
#include "overlay/sim/promises.h"

namespace romano::sim {

/// Why the brokers of some component do not agree yet; empty when each component has one view of
/// all its brokers and follows its highest-ranked one (P1).
[[nodiscard]] std::optional<std::string> disagreement(ClusterWorld& world);

/// P1, P4, P6 over all components. For a cluster that agrees, with idle robots.
void judge_settlement(ClusterWorld& world, Violations& out);

}  // namespace romano::sim
