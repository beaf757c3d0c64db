// An heir's work after a view change: adopt the sessions of the addresses that were assigned to it
// and answer on these addresses.
//
// It waits until it holds the dead broker's log up to the agreed end (fetching.h); after some time
// it goes on with what it has. When the address's own broker is back and serving by then, the
// sessions are passed on to it instead (departures.h), as soon as it hears us in its new life, and
// with all that they missed: a newcomer holds none of the removed brokers' logs. When several
// inherit an address, each from another log, the address is the first heir's, and the others pass
// their sessions on to it in the same way; until then it is silent there, for its copy of a session
// may be the older one. When the first heir does not serve the address in time, they adopt the
// sessions without it. A session that its home had moved to a member of the view stays with that
// member. While the removed broker is heard to serve the address, it keeps it. Until the first heir
// serves it nobody else takes it, its own broker neither: both would before they hear of each
// other.
//
// From an outdated log the heir takes what nobody else has; to know that, it first reads all that
// the members say.
//
// Many sessions are adopted in pieces, those first for which somebody waits. What a client says
// waits until its session is here, and what strangers say until all are.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "overlay/cluster/agreement/membership.h"
#include "overlay/cluster/agreement/view_change.h"
#include "overlay/cluster/effects.h"
#include "overlay/cluster/ownership/adoption.h"
#include "overlay/cluster/ownership/awaited_sessions.h"
#include "overlay/cluster/ownership/departures.h"
#include "overlay/cluster/ownership/service_addresses.h"

namespace romano::cluster {

class TakeOver {
public:
    TakeOver(BrokerId self, std::size_t sessions_per_turn)
        : self_(self), sessions_per_turn_(sessions_per_turn) {}

    void on_view(Instant now, const ViewAnnouncement& announcement,
                 const ServiceAddresses& addresses);
    /// A new turn: the next carry_on() goes on with what is half adopted.
    void on_turn() { may_go_on_ = true; }
    /// Does what has become possible (model: adopt). Begins nothing unless `may_begin`: if we have
    /// promised another view, its leader may give what is left to somebody else (I1).
    void carry_on(Effects& effects, const Logs& logs, const Membership& membership,
                  const View& view, ServiceAddresses& addresses, Departures& departures,
                  bool may_begin);
    /// We are to go on from that log, and have not begun.
    [[nodiscard]] bool awaits(const LogId& log) const;
    /// These addresses have some of their sessions here, and others not yet.
    [[nodiscard]] std::set<Endpoint> half_adopted() const;
    /// We adopt sessions of these addresses, or are about to.
    [[nodiscard]] std::set<Endpoint> inheriting() const;
    [[nodiscard]] bool is_half_adopted(const Endpoint& address) const;
    /// Sessions are left to be adopted, and we know that nobody waits for them.
    [[nodiscard]] bool may_rest() const;
    /// Its sessions come from several logs: which copy of one stays is known when all are here.
    [[nodiscard]] bool is_adopted_from_several(const Endpoint& address) const;
    /// Other heirs have copies of its sessions, too: which one stays is known when those are here
    /// (P3).
    [[nodiscard]] bool awaits_heirs(const Endpoint& address) const {
        return awaited_heirs_.contains(address);
    }
    void on_handed_over(BrokerId from, const Endpoint& address);
    /// A view named another member as its first heir, which may serve it before we hear so.
    [[nodiscard]] bool is_left_to_another(const Endpoint& address) const {
        return left_to_.contains(address);
    }
    /// Somebody waits for the sessions that want such messages, or for that client's.
    void on_publish(std::string_view topic);
    void on_client(const broker::ClientId& client) { awaited_.on_client(client); }
    /// Service addresses of the dead that were inherited so far.
    [[nodiscard]] std::uint64_t inherited() const { return inherited_; }
    void restart() {
        pending_.clear();
        others_.clear();
        awaited_heirs_.clear();
        left_to_.clear();
        awaited_.clear();
    }

private:
    struct Pending {
        Assignment assignment;
        Instant since;
        bool is_begun = false;
        std::optional<LogId> server = {};            // to whom they are passed on
        std::vector<broker::ClientId> clients = {};  // to be looked at
        std::size_t listed = 0;                      // of those: which are awaited is known
        std::size_t looked_at = 0;
    };

    [[nodiscard]] bool holds_all(const Logs& logs, const Membership& membership,
                                 const View& view) const;
    [[nodiscard]] static bool is_complete(const Effects& effects, const PeerLog& dead,
                                          const Logs& logs, bool for_another);
    [[nodiscard]] bool is_out_of_patience(Effects& effects, const Pending& pending) const;
    void begin(Effects& effects, Pending& pending, PeerLog& log, const Membership& membership,
               ServiceAddresses& addresses);
    /// Lists some of those that are to be looked at. False when all are listed.
    bool list_some(Pending& pending, const PeerLog& log);
    /// True when none is left.
    bool adopt_some(Effects& effects, Pending& pending, PeerLog& log, const Logs& logs,
                    const std::vector<broker::ClientId>& awaited, Departures& departures);
    /// If its session is left there.
    void adopt_one(Effects& effects, const Pending& pending, PeerLog& log, const Logs& logs,
                   const broker::ClientId& client, Departures& departures) const;

    BrokerId self_;
    std::size_t sessions_per_turn_;
    bool may_go_on_ = false;
    std::vector<Pending> pending_;
    AwaitedSessions awaited_;    // of those that are begun
    std::set<Endpoint> others_;  // that the view gave to other heirs first
    struct AwaitedHeirs {
        std::set<BrokerId> heirs = {};
        Instant since = {};
    };
    std::map<Endpoint, AwaitedHeirs> awaited_heirs_;
    struct FirstHeir {
        BrokerId heir = {};
        Instant since = {};
    };
    std::map<Endpoint, FirstHeir> left_to_;
    std::uint64_t inherited_ = 0;
};

}  // namespace romano::cluster
