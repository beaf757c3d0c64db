// Cluster messages of every kind with random contents, for round trips.
#pragma once

#include "overlay/cluster/messages.h"
#include "romano/base/random.h"

namespace romano::dds {

inline constexpr std::size_t message_kinds = std::variant_size_v<cluster::ClusterMessage>;

/// `kind` is the index in ClusterMessage.
[[nodiscard]] cluster::ClusterMessage random_message(std::size_t kind, Random& random);

}  // namespace romano::dds
