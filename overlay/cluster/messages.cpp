#include "overlay/cluster/messages.h"

namespace romano::cluster {

Delivery delivery_of(const ClusterMessage& message) {
    if (std::holds_alternative<Beacon>(message)) return Delivery::beacon;
    if (std::holds_alternative<LogBatch>(message)) return Delivery::log;
    if (std::holds_alternative<ForwardBatch>(message)) return Delivery::best_effort;
    return Delivery::direct;
}

}  // namespace romano::cluster
