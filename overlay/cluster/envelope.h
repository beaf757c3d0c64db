// A cluster message with its sender or its receivers.
#pragma once

#include <optional>
#include <vector>

#include "overlay/cluster/messages.h"

namespace romano::cluster {

/// A received message with its sender. The incarnation is that of the sender's process: a member
/// that had to begin a new log says so in its messages.
struct Envelope {
    LogId from;
    ClusterMessage message;
};

/// A message to send: to one broker, or to all others.
struct Outgoing {
    std::optional<BrokerId> to;  // empty: broadcast
    ClusterMessage message;
};

/// What a part of the cluster core wants sent, in order.
using Outbox = std::vector<Outgoing>;

}  // namespace romano::cluster
