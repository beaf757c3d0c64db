// A world with one broker that is no member of anything.
#pragma once

#include "overlay/sim/lone_broker.h"
#include "overlay/sim/world.h"

namespace romano::sim {

class LoneWorld : public World {
public:
    /// The broker is up at once. It serves service_address(0).
    explicit LoneWorld(std::uint64_t seed, broker::BrokerOptions options = quick_broker());

    [[nodiscard]] LoneBroker& broker() { return broker_; }

    /// Broker options with times that suit virtual minutes: T_retry as the robots have it.
    [[nodiscard]] static broker::BrokerOptions quick_broker();

private:
    LoneBroker broker_;
};

}  // namespace romano::sim
