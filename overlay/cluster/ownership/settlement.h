// One client, two homes: after a heal, or when two brokers adopted it. The copy that outranks the
// other stays (broker::outranks; the higher broker id at a full tie), the other home moves its copy
// there (departures.h; design section 3, "Joining and healing").
//
// Mirrors know when a client was last heard only as of the last event, so the homes tell each other
// directly: each claims its copy to the other, and who sees itself outranked gives way. Ranks of a
// copy only grow, so never do both.
#pragma once

#include <set>
#include <utility>
#include <vector>

#include "overlay/cluster/agreement/membership.h"
#include "overlay/cluster/effects.h"
#include "overlay/cluster/ownership/departures.h"
#include "overlay/cluster/ownership/hand_back.h"
#include "overlay/cluster/replication/peer_log.h"

namespace romano::cluster {

class Settlement {
public:
    explicit Settlement(BrokerId self) : self_(self) {}

    /// A peer's log says that it is home to this client.
    void on_peer_session(const Effects& effects, BrokerId peer, const broker::ClientId& client);
    /// Looks for all clients that are homed here and at another member; in pieces.
    void compare(const broker::BrokerCore& broker, const View& view);
    void compare_some(const PeerLogs& logs);
    /// There is more to look at.
    [[nodiscard]] bool is_half_done() const { return !to_compare_.empty(); }

    /// Claims what both hold, from time to time.
    /// Sessions of an address that is on its way (`moving`) are settled by the address's owner.
    void carry_on(Effects& effects, const PeerLogs& logs, const HandBack& moving);
    /// Where topic ids mean something else, neither copy goes on from the other; the one stays to
    /// which the client spoke last.
    void on_claim(Effects& effects, const LogId& from, const SessionClaim& claim,
                  const HandBack& moving, Departures& departures, const PeerLogs& logs);

    static constexpr std::size_t compared_per_turn = 2'000;  // about a millisecond

private:
    BrokerId self_;
    std::vector<broker::ClientId> to_compare_;
    std::vector<LogId> compared_with_;
    std::set<std::pair<broker::ClientId, BrokerId>> conflicts_;
    Instant next_claims_ = Instant::min();
};

}  // namespace romano::cluster
