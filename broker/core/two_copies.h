// Two brokers were home to one client: what becomes of the two copies of its session. One stays,
// and takes from the other what the client knows or has from that one.
#pragma once

#include <vector>

#include "broker/core/message.h"
#include "broker/core/session_image.h"

namespace romano::broker {

struct Settled {
    SessionImage image = {};  // the copy that stays
    bool comes = true;        // it is the one that comes from elsewhere
    bool is_new = true;       // it differs from the own copy
    mqttsn::MsgId last_msg_id_elsewhere = mqttsn::no_msg_id;  // of the other copy
    /// Of a QoS 2 exchange that was begun and does not go on: the client may wait for its end.
    mqttsn::MsgId unfinished = mqttsn::no_msg_id;
};

/// The own copy of a session and one that comes; `missed` is what the latter's home has not worked
/// through. What one home delivered is left out of what waits in the other one's copy.
[[nodiscard]] Settled settle(SessionImage own, SessionImage comes, std::vector<MessagePtr>& missed);

}  // namespace romano::broker
