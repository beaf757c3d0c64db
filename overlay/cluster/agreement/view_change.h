// From suspicion to an agreed view.
//
// The leader proposes; a member freezes the logs of brokers that the new view leaves out and
// answers how far it holds them; the leader has missing tails sent to those that lack them and
// announces the view, with the heirs of every address that is left without a broker. A member
// answers only the leader that its own elector follows, so a leader must wait until the others see
// the same world; one that stays silent and follows somebody else is left out. Whatever a broker
// asks for with the number of an old view is ignored.
//
// A newcomer is asked into the view when it and each member hear each other, or have not found each
// other for long.
//
// A promise is given up for a higher number only, and no clock takes it back (invariant I4): its
// view may be announced at any time. Heartbeats say what was promised, and a leader goes beyond it.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <vector>

#include "overlay/cluster/agreement/ended_logs.h"
#include "overlay/cluster/agreement/membership.h"
#include "overlay/cluster/ownership/heirs.h"
#include "overlay/cluster/ownership/service_addresses.h"
#include "overlay/cluster/replication/peer_log.h"
#include "overlay/cluster/speaking/lease.h"

namespace romano::cluster {

/// View change looks at these; the cluster core keeps them all.
struct Surroundings {
    const Membership& membership;
    Lease& lease;
    PeerLogs& logs;
    const ServiceAddresses& addresses;
    const EndedLogs& ended;
    std::uint32_t sessions = 0;  // the own ones
};

class ViewChange {
public:
    explicit ViewChange(LogId self) : self_(self) {}

    void on_tick(Instant now, Surroundings around, Outbox& out);
    void on_proposal(Instant now, const ViewProposal& proposal, Surroundings around, Outbox& out);
    void on_holdings(Instant now, const LogId& from, const ViewHoldings& holdings,
                     Surroundings around, Outbox& out);
    void on_announcement(Instant now, const ViewAnnouncement& announcement, Surroundings around);

    /// The view that was installed since the last call, with its assignments.
    [[nodiscard]] std::optional<ViewAnnouncement> take_installed();

    [[nodiscard]] const View& view() const { return view_; }
    [[nodiscard]] bool has_view() const { return !view_.members.empty(); }
    /// The highest number that was promised: what is below it is never entered.
    [[nodiscard]] const ViewNumber& promised() const { return promised_; }
    [[nodiscard]] bool contains(const LogId& log) const { return view_.contains(log); }
    /// We reach no other member of the view, and have never met some of them: they may be about to
    /// go on without us.
    [[nodiscard]] bool is_stranded(const Membership& membership, const PeerLogs& logs) const;
    /// Goes on as another member: in no view until the leader takes it into one.
    void restart(LogId self);
    /// Whoever leads then asks anew for what was asked before.
    void on_standstill();
    /// We promised that view, and not before the last standstill.
    [[nodiscard]] bool is_promised_anew(const View& view) const {
        return view.number == promised_ && promised_ > promised_before_;
    }
    /// Until then we wait for the lease of a member that the next view leaves out.
    [[nodiscard]] Instant next_wakeup() const { return waits_until_; }

private:
    struct Proposal {
        ViewProposal message;
        std::map<LogId, ViewHoldings> answers;
        Instant since;
        Instant asked_at;
    };

    [[nodiscard]] bool waits_for_company(Instant now, Surroundings around);
    [[nodiscard]] bool misses_company(const Membership& membership) const;
    [[nodiscard]] bool misses_home(const Membership& membership) const;
    [[nodiscard]] std::vector<LogId> desired_members(Instant now, const Membership& membership);
    [[nodiscard]] bool must_meet_others(Instant now, const Peer& newcomer,
                                        const Membership& membership);
    [[nodiscard]] bool needs_change(Instant now, const std::vector<LogId>& desired,
                                    Surroundings around) const;
    [[nodiscard]] bool is_newer(const View& view) const;
    void answer_early_proposal(Instant now, Surroundings around, Outbox& out);
    [[nodiscard]] bool must_wait(Instant now, const ViewProposal& proposal, Surroundings around);
    void propose(Instant now, std::vector<LogId> members, Surroundings around, Outbox& out);
    [[nodiscard]] ViewNumber next_number(const Membership& membership) const;
    [[nodiscard]] bool is_outnumbered(const Membership& membership) const;
    void ask(Instant now, Outbox& out);
    void lead(Instant now, Surroundings around, Outbox& out);
    [[nodiscard]] bool may_promise(Instant now, const View& next, Surroundings around);
    void promise(const View& next, Surroundings around);
    void give_up_on_silent(Instant now, const Membership& membership);
    void conclude(Instant now, Surroundings around, Outbox& out);
    void announce_again(Instant now, const Membership& membership, Outbox& out);
    [[nodiscard]] bool is_asked_again(const View& view) const;
    [[nodiscard]] ViewHoldings holdings(const View& view, Surroundings around) const;
    void install(Instant now, ViewAnnouncement announcement, Surroundings around);

    LogId self_;
    View view_;
    Instant installed_at_{};
    bool was_replaced_ = false;  // and is in no view since
    std::optional<ViewAnnouncement> installed_;
    Appointed appointed_;  // by the view

    /// We cannot answer this proposal yet. Its leader noticed before us that the former one is
    /// gone, or leaves out a member that we hear well, and may hear that one again. We answer when
    /// that has changed, unless the leader must have asked again since.
    struct EarlyProposal {
        ViewProposal message;
        Instant first;  // when the leader first asked this
        Instant last;
    };
    std::optional<EarlyProposal> early_;
    Instant waits_until_ = never;  // for a lease
    std::optional<View> wanted_;   // meanwhile
    ViewNumber promised_;  // the highest proposal that was answered; never below view_.number
    ViewNumber promised_before_;  // the last standstill

    Instant led_since_ = never;
    std::optional<Proposal> proposal_;  // while leading
    struct Announced {
        ViewAnnouncement message;
        Instant said_at;
    };
    std::optional<Announced> announced_;  // by us, until another view is promised
    std::set<BrokerId> refusing_;         // alive, but followers of somebody else
    std::map<LogId, Instant> newcomers_;  // in no view: since when they are known
};

}  // namespace romano::cluster
