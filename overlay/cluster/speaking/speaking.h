// Who may speak, and who is heard: the one place that decides it, from what others keep.
//
//     what is said to a client    leaves      with a lease, from an address that is here
//                                 waits       without a lease, or while the address is being bound
//                                 is dropped  where the sessions of the address leave, or another
//                                             broker serves it too, that has not handed them over,
//                                             or other heirs have not passed on theirs
//
//     what a client says          is heard    with a lease, if nothing of it is on its way
//                                 waits       without view or lease; before all members are met;
//                                             while its session comes, or may come back
//                                 is dropped  where the sessions of the address leave
//
// So no two brokers speak at one address (I1), and nothing is heard for a session that is not here
// (I5, I7). What waits: held_output.h, waiting_input.h.
#pragma once

#include "overlay/cluster/agreement/acquaintance.h"
#include "overlay/cluster/agreement/view_change.h"
#include "overlay/cluster/ownership/departures.h"
#include "overlay/cluster/ownership/hand_back.h"
#include "overlay/cluster/ownership/service_addresses.h"
#include "overlay/cluster/ownership/take_over.h"
#include "overlay/cluster/speaking/held_output.h"
#include "overlay/cluster/speaking/lease.h"

namespace romano::cluster {

class Speaking {
public:
    /// What decides. All of it outlives this object.
    struct Grounds {
        const ViewChange& views;
        const Acquaintance& acquaintance;
        const Lease& lease;
        const TakeOver& take_over;
        const HandBack& hand_back;
        const Departures& departures;
        const ServiceAddresses& addresses;
    };

    explicit Speaking(const Grounds& grounds) : by_(grounds) {}

    // --- this broker
    /// The members of the view vouch for it that this broker is in its place there, and nobody else
    /// speaks in its place any more (model: may_speak).
    [[nodiscard]] bool may_speak(Instant now) const {
        return by_.lease.is_held(now) && !by_.acquaintance.is_returning(now);
    }
    /// Others may have gone on for it.
    [[nodiscard]] bool has_lost_lease(Instant now) const {
        return by_.views.has_view() && !may_speak(now);
    }

    // --- a service address
    /// What becomes of something that is said from there now.
    [[nodiscard]] HeldOutput::Fate said_from(Instant now, const Endpoint& address) const;
    /// Nothing is said from there: it would be dropped.
    [[nodiscard]] bool is_silent(const Endpoint& address) const {
        return by_.hand_back.is_silent(address) || by_.take_over.awaits_heirs(address);
    }
    /// Its sessions are about to leave: what comes for them is theirs no more.
    [[nodiscard]] bool is_deaf(const Endpoint& address) const {
        return by_.hand_back.is_deaf(address);
    }
    /// What clients say there waits, or is another broker's to hear.
    [[nodiscard]] bool is_unheard(const Endpoint& address) const {
        return is_silent(address) || by_.hand_back.is_expecting(address);
    }
    /// Clients are served there: neither does anything wait that they say, nor what is said to
    /// them.
    [[nodiscard]] bool is_open(const Endpoint& address) const {
        return by_.addresses.is_serving(address) && !is_unheard(address);
    }

    // --- a client
    /// A datagram from there to `via` waits for the lease, or for its session.
    [[nodiscard]] bool must_wait(Instant now, const broker::BrokerCore& broker, const Endpoint& via,
                                 const Endpoint& from, Bytes datagram) const {
        return has_lost_lease(now) || waits_for_session(broker, via, from, datagram);
    }
    /// There is no view yet, or we have not met all who took us into it, or the session may be on
    /// its way.
    [[nodiscard]] bool waits_for_session(const broker::BrokerCore& broker, const Endpoint& via,
                                         const Endpoint& from, Bytes datagram) const;

private:
    Grounds by_;
};

}  // namespace romano::cluster
