#include "overlay/cluster/messages.h"

#include <algorithm>

namespace romano::cluster {

Seq Beacon::applied_through(const LogId& of) const {
    const auto found = std::ranges::find(applied, of, &LogPosition::log);
    return found == applied.end() ? 0 : found->seq;
}

Delivery delivery_of(const ClusterMessage& message) {
    if (std::holds_alternative<Beacon>(message)) return Delivery::beacon;
    if (std::holds_alternative<LogBatch>(message)) return Delivery::log;
    if (std::holds_alternative<ForwardBatch>(message)) return Delivery::best_effort;
    return Delivery::direct;
}

}  // namespace romano::cluster
