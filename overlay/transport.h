// What the cluster needs of a network between brokers. Two implementations: dds/ and sim/.
//
// Best-effort and reliable messages as overlay/cluster/messages.h says; a reliable message to a
// peer that is unreachable for long may be lost, and its receiver notices by the positions. Sending
// never blocks.
#pragma once

#include <functional>

#include "overlay/cluster/envelope.h"

namespace romano::overlay {

using cluster::Envelope;
using cluster::Outgoing;

class Transport {
public:
    using Receiver = std::function<void(const Envelope&)>;

    virtual ~Transport() = default;

    /// Messages come to `receiver` on the owner's thread, never from within send().
    virtual void start(Receiver receiver) = 0;
    virtual void send(const Outgoing& message) = 0;
};

}  // namespace romano::overlay
