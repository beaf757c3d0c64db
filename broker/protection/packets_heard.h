// How far a client's packets were taken: what brokers tell each other, and keep through a crash.
#pragma once

#include "romano/protection/broker_end.h"
#include "romano/protection/packet.h"

namespace romano::broker {

struct PacketsHeard {
    protection::SenderId sender{};
    protection::Heard heard{};

    friend bool operator==(const PacketsHeard&, const PacketsHeard&) = default;
};

}  // namespace romano::broker
