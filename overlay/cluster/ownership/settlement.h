// One client, two homes: after a heal, or when two brokers adopted it. The copy that outranks the
// other stays (broker::outranks; the higher broker id at a full tie), the other home moves its copy
// there (departures.h).
//
// Each home compares its own copy with the mirror of the other home's log. A mirror knows when a
// client was last heard only as of the last event, so a home that stays writes that into its log.
//
// I7, at once: the lower copy's home gives way in the turn in which it reads of the higher one,
// whether or not that one's home hears it. A copy on its way to a third home counts as that one's.
// All conflicts are looked at again from time to time.
//
// I7, never both: the rank of a copy does not fall, and a mirror shows one that the copy had. If
// both homes gave way, each copy would have ended below a rank that the other one had before.
//
// P4, one home gives way in the end: both notice the conflict, whichever became a home last. The
// client talks to one address at a time, so that one copy hears it. That copy's rank is written
// whenever it has grown, and the other one's once. When both mirrors show these, the lower copy's
// home sees that it is the lower one. If the higher copy does not hear the client, its rank is
// final; if the lower one does not, whatever is written of the higher one lies above it.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "overlay/cluster/agreement/membership.h"
#include "overlay/cluster/effects.h"
#include "overlay/cluster/ownership/departures.h"
#include "overlay/cluster/ownership/hand_back.h"
#include "overlay/cluster/replication/peer_log.h"

namespace romano::cluster {

class Settlement {
public:
    Settlement(BrokerId self, std::size_t sessions_per_turn)
        : self_(self), sessions_per_turn_(sessions_per_turn) {}

    /// A peer's log says that it is home to this client, or what has changed there.
    void on_peer_session(const Effects& effects, const LogId& peer, const broker::ClientId& client);
    /// This broker is home to the client: another home sees that when our log says so, and no
    /// sooner.
    void on_own_session(const broker::ClientId& client, const PeerLogs& logs);
    /// Looks for all clients that are homed here and at another member; in pieces.
    void compare() { next_compared_ = 0; }
    void compare_some(const broker::BrokerCore& broker, const PeerLogs& logs, const View& view);
    /// An address is silent no more: its sessions are settled before anything is said there.
    void look_again() { next_look_ = Instant::min(); }
    /// I7: where a session that comes here is spoken for already; this broker never speaks then.
    [[nodiscard]] std::optional<LogId> home_of_higher(broker::SessionHeader comes,
                                                      const PeerLogs& logs,
                                                      const Membership& membership) const;
    /// More conflicts are to be looked at.
    [[nodiscard]] bool is_half_done() const {
        return next_compared_.has_value() || goes_on_at_.has_value() || !news_.empty();
    }

    /// Gives way, or says how the own copy is, from time to time; in pieces.
    /// Sessions of an address that is on its way (`moving`) are settled by the address's owner.
    void carry_on(Effects& effects, const PeerLogs& logs, const Membership& membership,
                  const HandBack& moving, Departures& departures);

    static constexpr std::size_t compared_per_turn = 1'000;  // half a millisecond

private:
    using Conflict = std::pair<broker::ClientId, LogId>;

    void heed(Conflict conflict);
    enum class Outcome : std::uint8_t { lasts, gives_way, is_over };
    /// `told`: when the own copy was last heard, as the own log says.
    Outcome settle(Effects& effects, const Conflict& conflict, broker::HybridTime& told,
                   const PeerLogs& logs, const Membership& membership, const HandBack& moving,
                   Departures& departures) const;
    struct Copy {
        const broker::SessionHeader& header;
        LogId home;  // or it is on its way there
    };
    /// None when it comes here.
    [[nodiscard]] std::optional<Copy> copy_in(const PeerLog& log,
                                              const broker::ClientId& client) const;
    [[nodiscard]] bool gives_way(const broker::SessionHeader& own, const PeerLog& other,
                                 const broker::SessionHeader& theirs, BrokerId home) const;

    BrokerId self_;
    std::size_t sessions_per_turn_;
    std::optional<std::uint32_t> next_compared_;  // a session's number; none when all are
    std::map<Conflict, broker::HybridTime> conflicts_;
    std::set<Conflict> news_;             // looked at in the next turn, as many as that allows
    std::optional<Conflict> goes_on_at_;  // in the next turn
    Instant next_look_ = Instant::min();
};

}  // namespace romano::cluster
