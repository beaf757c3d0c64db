// Who gets a message, and how: the router's list while it hands one on.
#pragma once

#include "broker/core/session.h"

namespace romano::broker {

struct Receiver {
    Session* session;
    mqttsn::Qos qos;  // min(published, granted)
    WireTopic topic;
    bool takes;            // of QoS 1 and 2: there is room in its queue
    bool at_cell = false;  // served by a datagram to the cell
};

}  // namespace romano::broker
