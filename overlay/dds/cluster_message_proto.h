// Cluster messages as Protobuf: overlay/cluster/messages.h.
#pragma once

#include <optional>

#include "overlay/cluster/messages.h"
#include "overlay/dds/cluster_message.pb.h"

namespace romano::overlay::proto {

void to_proto(const cluster::ClusterMessage& in, ClusterMessage& out);
[[nodiscard]] std::optional<cluster::ClusterMessage> from_proto(const ClusterMessage& in);

}  // namespace romano::overlay::proto
