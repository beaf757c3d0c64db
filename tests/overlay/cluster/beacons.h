// A peer's beacon as it comes: what is said of it often, and the particulars.
#pragma once

#include "overlay/cluster/cluster_core.h"

namespace romano::cluster {

inline void hear(ClusterCore& core, Effects& effects, const Beacon& beacon) {
    HeartbeatWriter writer;
    core.on_message(effects, {beacon.log, writer.write(beacon)});
    core.on_message(effects, {beacon.log, Particulars{beacon}});
}

}  // namespace romano::cluster
