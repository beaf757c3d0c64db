// An application message on its way: published once, shared by all queues that it waits in.
//
// Immutable after publication, so that a fan-out copies pointers. `position` names the message in
// the cluster: the place of its Published event. A message of QoS 0 that is not retained is in no
// log; its position's seq is 0.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "broker/core/hybrid_time.h"
#include "broker/core/log_position.h"
#include "romano/base/shared.h"
#include "romano/mqttsn/types.h"

namespace romano::broker {

struct Message {
    std::string topic;
    std::vector<std::uint8_t> payload;
    mqttsn::Qos qos = mqttsn::Qos::at_most_once;  // as published; QoS -1 is stored as 0
    bool retain = false;                          // as published
    LogPosition position;
    HybridTime published_at;
    std::string origin = {};  // names what came over the uplink; empty: a client published it
};

using MessagePtr = Shared<Message>;

}  // namespace romano::broker
