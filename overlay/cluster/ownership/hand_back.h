// An address goes back to its own broker, with its sessions, without its clients noticing.
//
//     holder                                owner (in the view, does not serve its home address)
//       |                                      |  hears who serves it, and binds it, too
//       |<--- Particulars: bound, waiting -----|  datagrams come here now, and wait
//       |  lets pending answers leave,         |
//       |  falls silent                        |
//       |<--- SessionRequest ... --------------|  of clients that speak: these come first
//       |------- log: SessionMoved ... ------->|  adopts from its mirror of the log, and serves
//       |------- log: Sealed ----------------->|  serves strangers
//       |<------ log: SessionPut ... ----------|
//       |  unbinds                             |
//
// So many sessions at most are on their way at a time, so that a wanted one is soon there. Sessions
// go first whose clients speak, or for which a message waits.
//
// After a heal two brokers may serve an address: it belongs to the one whose home address it is,
// else to the one with the higher id. The broker that does not own it falls silent as soon as it
// hears of the other, and so does the owner. The owner claims the address, so that datagrams come
// to it and wait, as soon as the other one hears it, and once more in each view. The other begins
// at "SessionMoved" when they are in one view; the ranks of two copies of a session settle which
// stays (broker::outranks). A move that both want counts like being heard: it raises the epoch, so
// that the holder's copy never wins again.
//
// A rival's machine may call datagrams to itself for as long as it has the address: to send from
// there, its kernel asks for the client's hardware address in the name of our address. So the owner
// announces the address once more when the rival has let it go.
//
// A broker that goes on at an address where its owner, or a rival, has fallen silent takes it anew:
// datagrams may still come to that one, which may have stopped and not died.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <vector>

#include "overlay/cluster/agreement/membership.h"
#include "overlay/cluster/effects.h"
#include "overlay/cluster/ownership/departures.h"
#include "overlay/cluster/ownership/service_addresses.h"

namespace romano::cluster {

class HandBack {
public:
    HandBack(BrokerId self, std::size_t sessions_per_turn)
        : self_(self), sessions_per_turn_(sessions_per_turn) {}

    // --- the holder's side
    /// What must be done before an address can go.
    struct NotYet {
        const std::set<Endpoint>& pending_output;  // answers still wait to leave from there
        const std::set<Endpoint>& half_adopted;    // its sessions are not all here
        const std::set<Endpoint>& inheriting;      // nor those that an heir, we, shall take over
    };
    /// Gives what belongs to others, and goes on with what is under way; many sessions leave in
    /// pieces.
    void carry_on(Effects& effects, const Logs& logs, const Membership& membership,
                  const View& view, ServiceAddresses& addresses, Departures& departures,
                  const NotYet& not_yet);
    [[nodiscard]] bool is_half_done(const Departures& departures) const;
    /// Somebody waits for what is to be given.
    [[nodiscard]] bool is_awaited() const;
    /// Something waits for the client, or it speaks to the owner: its session leaves first.
    void on_awaited(const broker::SessionHeader& client);
    /// Looks who else serves our addresses. Whoever did when it was heard last, and is a member
    /// still, may serve them now: that it fell silent here is no proof of its death. An own address
    /// is claimed as soon as a rival hears us, and so is silent there; another one when the broker
    /// to which it belongs is not heard any more.
    void compare(Effects& effects, const Membership& membership, const View& view,
                 const ServiceAddresses& addresses);
    /// compare() found another broker that serves one of our addresses.
    [[nodiscard]] bool has_rivals() const { return !contested_.empty() || !rivals_.empty(); }
    /// The address's sessions are on their way, or it belongs to another broker that serves it: we
    /// take nothing that clients say there.
    [[nodiscard]] bool is_deaf(const Endpoint& address) const;
    /// We say nothing there. The owner is silent, too, before it has what its rivals had; what it
    /// hears waits. It speaks to those who have come from its only rival, which is silent then.
    [[nodiscard]] bool is_silent(const Endpoint& address) const;

    // --- the owner's side
    /// Binds home addresses beside members that serve them and hear us.
    void reclaim(Effects& effects, const Membership& membership, const View& view,
                 ServiceAddresses& addresses);
    void on_address(Instant now, const Endpoint& address, bool served);
    /// We have bound the address beside another broker, or are about to.
    [[nodiscard]] bool is_reclaiming(const Endpoint& address) const {
        return reclaiming_.contains(address);
    }
    /// We have bound the address, and are silent until its sessions are here. Our beacons say so,
    /// and the giver speaks until it moves them.
    [[nodiscard]] bool is_binding(const Endpoint& address) const {
        return expected_.contains(address);
    }
    [[nodiscard]] std::vector<Endpoint> binding() const;
    /// The sessions of an own address are somewhere else and will come from there: from these lives
    /// of brokers, or from the heirs of those that die.
    void expect(Instant now, const Endpoint& address, std::set<LogId> from);
    void on_handed_over(BrokerId from, const Endpoint& address);
    /// Another broker served our address as well, and has not handed its sessions over yet.
    [[nodiscard]] bool is_unsettled(const Endpoint& address) const;
    /// Datagrams to the address shall wait.
    [[nodiscard]] bool is_expecting(const Endpoint& address) const {
        return is_binding(address) || is_unsettled(address);
    }

private:
    enum class Stage : std::uint8_t { draining, moving, sealed };
    struct Giving {
        LogId owner;
        Stage stage = Stage::draining;
        Instant since;
        bool contested;                              // the owner speaks there as well
        std::vector<broker::ClientId> clients = {};  // to be moved
        std::size_t moved = 0;
        std::set<broker::ClientId> awaited = {};  // before the others
    };
    struct Expected {
        std::set<LogId> from;
        Instant since;
    };

    void begin(Effects& effects, const Endpoint& address, const Logs& logs,
               const Membership& membership, const View& view);
    [[nodiscard]] bool is_called_off(const Effects& effects, const Endpoint& address,
                                     const Giving& giving, const Membership& membership,
                                     const View& view, const Departures& departures,
                                     const NotYet& not_yet) const;
    /// True when all that were there have left.
    bool move_some(Effects& effects, const Endpoint& address, Giving& giving, const PeerLogs& logs,
                   Departures& departures) const;
    [[nodiscard]] bool has_one_giver(const Endpoint& address) const;
    [[nodiscard]] static bool is_in_vain(const Effects& effects, const Expected& expected,
                                         bool is_heir, const Membership& membership,
                                         const View& view);

    BrokerId self_;
    std::size_t sessions_per_turn_;
    std::map<Endpoint, BrokerId> contested_;  // served by another broker, to whom they belong
    std::map<Endpoint, Giving> giving_;
    struct Rivalry {
        std::set<BrokerId> with = {};
        Instant since = {};                         // with these, or fewer
        Instant together_since = {};                // in one view with all of them
        std::set<BrokerId> handed_over = {};        // they did
        bool is_in_vain = false;                    // the others were waited for long enough
        std::optional<ViewNumber> claimed_in = {};  // datagrams come here, and wait
        void on_rivals(Instant now, std::set<BrokerId> rivals);
        [[nodiscard]] bool is_settled() const;
    };
    std::map<Endpoint, Rivalry> rivals_;  // for own addresses, that others serve as well
    std::map<Endpoint, std::set<LogId>> reclaiming_;  // own, being bound beside these
    std::map<Endpoint, Instant> tried_;               // own, could not be bound
    std::map<Endpoint, Expected> expected_;           // bound, the sessions not here yet
};

}  // namespace romano::cluster
