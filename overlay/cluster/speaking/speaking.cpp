#include "overlay/cluster/speaking/speaking.h"

namespace romano::cluster {

HeldOutput::Fate Speaking::said_from(Instant now, const Endpoint& address) const {
    if (is_silent(address)) return HeldOutput::Fate::is_dropped;
    const bool waits = by_.addresses.is_taking(address) || has_lost_lease(now);
    return waits ? HeldOutput::Fate::waits : HeldOutput::Fate::leaves;
}

bool Speaking::waits_for_session(const broker::BrokerCore& broker, const Endpoint& via,
                                 const Endpoint& from, Bytes datagram) const {
    if (!by_.views.has_view() || !by_.acquaintance.has_met_all()) return true;
    if (by_.departures.is_leaving(from) || by_.take_over.awaits_heirs(via)) return true;
    if (by_.take_over.is_half_adopted(via) || by_.hand_back.is_expecting(via)) {
        if (is_silent(via) || by_.take_over.is_adopted_from_several(via)) return true;
        return !broker.has_session_at(via, from, datagram);
    }
    // Who has no session here may be a robot that roams: its home's log is not read yet.
    return by_.acquaintance.may_roam() && !broker.serves(via, from, datagram);
}

}  // namespace romano::cluster
