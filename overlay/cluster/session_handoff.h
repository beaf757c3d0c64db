// Sessions on their way from one live home to another: sent in parts, adopted when the last part is
// there, acknowledged when the adoption is safe with peers. Until then the sender keeps them.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "overlay/cluster/adoption.h"
#include "overlay/cluster/effects.h"

namespace romano::cluster {

/// All sessions of one service address, or with `address` none: one session that roams.
void send_handoff(BrokerId to, const Endpoint& address, std::vector<broker::SessionImage> sessions,
                  Outbox& out);

class HandoffReceiver {
public:
    /// True when this was the last part: the sessions are adopted.
    bool on_handoff(Effects& effects, const Logs& logs, BrokerId from, SessionHandoff part);
    /// Sends the acknowledgements that the safe watermark allows.
    void carry_on(Effects& effects, Seq safe);
    void restart();

private:
    struct WaitingAck {
        Seq after;  // the last SessionPut of the adoption
        BrokerId to;
        HandoffAck ack;
    };

    // Bounded: one hand-over an address and peer; its size is the sender's own limit of sessions.
    std::map<std::pair<BrokerId, Endpoint>, std::vector<broker::SessionImage>> incoming_;
    std::vector<WaitingAck> acks_;
};

}  // namespace romano::cluster
