#include "experiments/measure/failover.h"

#include <algorithm>

namespace romano::experiments {

std::vector<ClientFailover> client_failovers(const DeliveryAccount& account,
                                             std::span<const RobotNumber> victims,
                                             double fault_at_s) {
    std::vector<ClientFailover> failovers;
    for (const RobotNumber victim : victims) failovers.push_back({.client = victim});
    for (const auto& messages : account.by_publisher()) {
        for (const PublishedMessage& message : messages) {
            if (message.sent_at_s < fault_at_s) continue;
            for (const Delivery& delivery : message.deliveries) {
                const auto victim =
                    std::ranges::find(failovers, delivery.receiver, &ClientFailover::client);
                if (victim == failovers.end()) continue;
                victim->was_addressed = true;
                if (!delivery.first_at_s) continue;
                const double after_ms = (*delivery.first_at_s - fault_at_s) * 1e3;
                victim->after_ms = std::min(victim->after_ms.value_or(after_ms), after_ms);
            }
        }
    }
    std::erase_if(failovers, [](const ClientFailover& each) { return !each.was_addressed; });
    return failovers;
}

}  // namespace romano::experiments
