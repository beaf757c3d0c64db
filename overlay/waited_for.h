// Which messages between brokers something depends on that was taken from clients: what is known of
// the clients' packets and records goes before them.
#pragma once

#include <variant>

#include "overlay/cluster/envelope.h"

namespace romano::overlay {

[[nodiscard]] inline bool is_waited_for(const cluster::Outgoing& outgoing) {
    return std::holds_alternative<cluster::LogBatch>(outgoing.message) ||
           std::holds_alternative<cluster::Heartbeat>(outgoing.message) ||
           std::holds_alternative<cluster::SnapshotPart>(outgoing.message);
}

}  // namespace romano::overlay
