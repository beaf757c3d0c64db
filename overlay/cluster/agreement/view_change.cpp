#include "overlay/cluster/agreement/view_change.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "overlay/cluster/replication/own_log.h"

namespace romano::cluster {
namespace {

/// Only who is dead to the leader, too, is taken over. Of one that it leaves out and hears still it
/// may hold more than was frozen there: an end without that would cost what comes next.
ViewHoldings without_the_living(ViewHoldings holdings, const PeerLogs& logs) {
    const auto lives = [&](const LogId& id) {
        const auto log = logs.find(id);
        return log != logs.end() && !log->second.is_frozen();
    };
    std::erase_if(holdings.holds, [&](const LogPosition& held) { return lives(held.log); });
    std::erase_if(holdings.addresses, [&](const auto& left) { return lives(left.log); });
    return holdings;
}

/// A member has promised a higher one, and enters none below that.
bool is_below_a_promise(const ViewNumber& number, const std::vector<LogId>& members,
                        const Membership& membership) {
    return std::ranges::any_of(members, [&](const LogId& member) {
        return membership.is_alive(member) &&
               membership.find(member.broker)->beacon.promised > number;
    });
}

}  // namespace

bool ViewChange::is_stranded(const Membership& membership, const PeerLogs& logs) const {
    bool has_met_all = true;
    for (const LogId& member : view_.members) {
        if (membership.is_alive(member)) return false;
        if (member != self_ && !logs.contains(member)) has_met_all = false;
    }
    return !has_met_all;
}

std::optional<ViewAnnouncement> ViewChange::take_installed() {
    return std::exchange(installed_, std::nullopt);
}

void ViewChange::restart(LogId self) {
    self_ = self;
    was_replaced_ = true;
    led_since_ = never;
    view_.members.clear();
    proposal_.reset();
    early_.reset();
    installed_.reset();
    announced_.reset();
    appointed_.clear();
}

/// Whoever waited for company has heard none meanwhile; and nobody refused an answer.
void ViewChange::on_standstill() {
    led_since_ = never;
    waits_until_ = never;
    proposal_.reset();
    refusing_.clear();
    promised_before_ = promised_;
}

/// Everybody whom the view leaves out has no lease any more, as far as we know; until then we echo
/// none of them (model: wait_for_leases).
bool ViewChange::may_promise(Instant now, const View& next, Surroundings around) {
    const auto has_ended = [&](const LogId& log) { return around.membership.has_ended(log); };
    const Instant over = around.lease.is_over_at(next, has_ended);
    if (now >= over) return true;
    waits_until_ = std::min(waits_until_, over);
    wanted_ = next;
    around.lease.want(&next);
    return false;
}

// --- the leader's side

void ViewChange::on_tick(Instant now, Surroundings around, Outbox& out) {
    waits_until_ = never;
    wanted_.reset();
    answer_early_proposal(now, around, out);
    lead(now, around, out);
    around.lease.want(wanted_ ? &*wanted_ : nullptr);
}

/// What a proposal that is called off has frozen stays so until a higher number is promised: its
/// members have promised it, as we have.
void ViewChange::lead(Instant now, Surroundings around, Outbox& out) {
    if (!around.membership.leads()) {
        led_since_ = never;
        proposal_.reset();
        refusing_.clear();
        return;
    }
    if (waits_for_company(now, around)) {
        proposal_.reset();
        return;
    }
    announce_again(now, around.membership, out);
    if (proposal_) {
        give_up_on_silent(now, around.membership);
        auto desired = desired_members(now, around.membership);
        if (desired != proposal_->message.view.members || is_outnumbered(around.membership)) {
            propose(now, std::move(desired), around, out);
        } else if (now >= proposal_->asked_at + around.membership.times().proposal_asked_every()) {
            ask(now, out);
        }
        return;
    }
    auto desired = desired_members(now, around.membership);
    if (needs_change(now, desired, around)) {
        propose(now, std::move(desired), around, out);
    }
}

/// Promises the view (model: promise). What an earlier proposal froze of members that stay goes on,
/// for nobody may announce that one any more. And whoever is in the next view may take for safe
/// what we hold of its log, before we have that view; not so who was replaced, for it begins anew.
///
/// Of brokers that are gone, what is left is frozen. One that is alive and not in the view, because
/// it has just started or follows another leader, serves its clients itself. Of the later life of
/// one that is in the view we may not have heard yet.
void ViewChange::promise(const View& next, Surroundings around) {
    promised_ = next.number;
    around.lease.on_promise(next);
    for (auto& [id, log] : around.logs) {
        if (next.contains(id)) {
            if (contains(id)) log.thaw();
            const bool was_replaced = around.ended.contains(id);
            if (!was_replaced) log.promised_with_writer();
        } else if (!around.membership.is_alive(id) || next.has_later_life_of(id)) {
            log.freeze();
        }
    }
}

/// The first view of a newcomer opens it to clients, whose sessions may be with a peer that does
/// not follow us yet, or of whom newcomers know nothing: it is given a moment. Longer, whoever is
/// there but was not met yet: a view without them would take their clients over.
bool ViewChange::waits_for_company(Instant now, Surroundings around) {
    const Membership& membership = around.membership;
    const Times times = membership.times();
    if (has_view() && !is_stranded(membership, around.logs)) return false;
    if (led_since_ == never) led_since_ = now;
    if (now < led_since_ + times.unmet_peer_waited_for() &&
        (membership.heard_unknown(now) || misses_company(membership))) {
        return true;
    }
    if (now < led_since_ + times.silent_home_waited_for() && misses_home(membership)) return true;
    if (now >= led_since_ + times.newcomer_listens_for(membership.peers().empty())) return false;
    bool are_newcomers = true;
    for (const auto& [id, peer] : membership.peers()) {
        if (!peer.alive) continue;
        are_newcomers = are_newcomers && peer.beacon.view.members.empty();
        if (!peer.beacon.claim.leader) return true;
    }
    return are_newcomers;
}

/// A peer's beacons come here while ours do not reach it yet; or a peer that we met hears another,
/// or is gone, and was in a view with another; or we have met nobody, and know from being replaced
/// that somebody is there.
bool ViewChange::misses_company(const Membership& membership) const {
    const auto is_met = [&](BrokerId id) {
        const Peer* peer = membership.find(id);
        return id == self_.broker || (peer != nullptr && peer->alive);
    };
    const auto is_unknown = [&](const LogId& member) {
        return member.broker != self_.broker && membership.find(member.broker) == nullptr;
    };
    bool is_alone = true;
    for (const auto& [id, peer] : membership.peers()) {
        if (!peer.alive) {
            if (membership.is_heard(id)) return true;
            if (!has_view() && std::ranges::any_of(peer.beacon.view.members, is_unknown)) {
                return true;
            }
            continue;
        }
        is_alone = false;
        if (!std::ranges::all_of(peer.beacon.hears, is_met)) return true;
    }
    return is_alone && was_replaced_;
}

/// We are newcomers, all that are here, and who has the sessions fell silent.
bool ViewChange::misses_home(const Membership& membership) const {
    bool are_newcomers = !has_view();
    bool is_home_silent = false;
    for (const auto& [id, peer] : membership.peers()) {
        const bool is_newcomer = peer.beacon.view.members.empty();
        are_newcomers &= is_newcomer || !peer.alive;
        is_home_silent |= !is_newcomer && !peer.alive && !peer.ended;
    }
    return are_newcomers && is_home_silent;
}

/// All that are alive, also followers of another leader: to leave one out means to take over its
/// clients, so it is asked first.
std::vector<LogId> ViewChange::desired_members(Instant now, const Membership& membership) {
    std::erase_if(newcomers_, [&](const auto& entry) { return !membership.is_alive(entry.first); });
    std::vector<LogId> members{self_};
    for (const auto& [id, peer] : membership.peers()) {
        if (!peer.alive) continue;
        const auto& leader = peer.beacon.claim.leader;
        if (leader == node_of(self_.broker)) refusing_.erase(id);
        // One that has just started follows nobody yet: it is not ready, and not refusing.
        const bool ready = contains(peer.beacon.log) ||
                           (leader.has_value() && !must_meet_others(now, peer, membership));
        if (ready && !refusing_.contains(id)) members.push_back(peer.beacon.log);
    }
    std::ranges::sort(members);
    return members;
}

/// In a view with somebody who never heard it a member has no lease (Lease): its clients would wait
/// until the two have found each other. Who has a view of its own has clients that wait, too.
bool ViewChange::must_meet_others(Instant now, const Peer& newcomer, const Membership& membership) {
    if (!newcomer.beacon.view.members.empty()) return false;
    const LogId& log = newcomer.beacon.log;
    const Instant since = newcomers_.try_emplace(log, now).first->second;
    if (now >= since + membership.times().unmet_peer_waited_for()) return false;
    return std::ranges::any_of(view_.members, [&](const LogId& member) {
        if (member == self_ || !membership.is_alive(member)) return false;
        return !newcomer.beacon.hears_from(member.broker) ||
               !membership.find(member.broker)->beacon.hears_from(log.broker);
    });
}

bool ViewChange::needs_change(Instant now, const std::vector<LogId>& desired,
                              Surroundings around) const {
    if (desired != view_.members || view_.number.leader != self_.broker) return true;
    // A proposal of ours or of another leader came to nothing: logs that it froze must live on.
    const Membership& membership = around.membership;
    if (promised_ > view_.number || is_below_a_promise(view_.number, desired, membership)) {
        return true;
    }
    // A broker died that was in no view of ours: somebody must go on for it, too.
    const bool has_orphans = std::ranges::any_of(around.logs, [&](const auto& entry) {
        return !entry.second.is_frozen() && !contains(entry.first) &&
               !membership.is_alive(entry.first);
    });
    if (has_orphans) return true;
    if (now < installed_at_ + membership.times().announcement_arrives_within()) return false;
    // A member that did not hear the announcement is asked into the view again.
    return std::ranges::any_of(membership.peers(), [this](const auto& entry) {
        const Beacon& beacon = entry.second.beacon;
        return contains(beacon.log) && beacon.view.number != view_.number;
    });
}

/// Promises a view of these members, and asks them to promise it (model: propose).
void ViewChange::propose(Instant now, std::vector<LogId> members, Surroundings around,
                         Outbox& out) {
    const ViewNumber number = next_number(around.membership);
    if (!may_promise(now, {number, members}, around)) return;
    proposal_.emplace(Proposal{.message = {.view = {number, std::move(members)}, .removed = {}},
                               .answers = {},
                               .since = now,
                               .asked_at = now});
    const View& view = proposal_->message.view;
    promise(view, around);
    for (const auto& [id, log] : around.logs) {
        if (!view.contains(id) && log.is_frozen()) proposal_->message.removed.push_back(id);
    }
    proposal_->answers.emplace(self_, holdings(view, around));
    ask(now, out);
    conclude(now, around, out);
}

/// Higher than all that was proposed here, and than what the others are in or have promised: one of
/// them may have been in a view of its own while it was out of sight.
ViewNumber ViewChange::next_number(const Membership& membership) const {
    ViewNumber newest = std::max(promised_, view_.number);
    for (const auto& [id, peer] : membership.peers()) {
        if (peer.alive) newest = std::max(newest, peer.beacon.promised);
    }
    ViewNumber number{.term = std::max(membership.leadership().term, newest.term),
                      .leader = self_.broker,
                      .count = 1};
    if (number.term > newest.term) return number;
    if (newest.leader == number.leader) {
        number.count = newest.count + 1;
    } else if (newest.leader > number.leader) {
        ++number.term;
    }
    return number;
}

/// Nobody may follow the proposal any more: it is of an earlier term, or a member has promised
/// more.
bool ViewChange::is_outnumbered(const Membership& membership) const {
    const View& proposed = proposal_->message.view;
    if (membership.leadership().term > proposed.number.term) return true;
    return is_below_a_promise(proposed.number, proposed.members, membership);
}

void ViewChange::ask(Instant now, Outbox& out) {
    proposal_->asked_at = now;
    for (const LogId& member : proposal_->message.view.members) {
        if (!proposal_->answers.contains(member)) {
            out.push_back({member.broker, proposal_->message});
        }
    }
}

void ViewChange::give_up_on_silent(Instant now, const Membership& membership) {
    if (now < proposal_->since + membership.times().disagreement_lasts()) return;
    for (const LogId& member : proposal_->message.view.members) {
        if (proposal_->answers.contains(member)) continue;
        const Peer* peer = membership.find(member.broker);
        if (peer == nullptr || peer->beacon.claim.leader != node_of(self_.broker)) {
            refusing_.insert(member.broker);
        }
    }
}

void ViewChange::on_holdings(Instant now, const LogId& from, const ViewHoldings& holdings,
                             Surroundings around, Outbox& out) {
    if (!proposal_ || holdings.number != proposal_->message.view.number) return;
    if (!proposal_->message.view.contains(from)) return;
    proposal_->answers.emplace(from, without_the_living(holdings, around.logs));
    conclude(now, around, out);
}

void ViewChange::conclude(Instant now, Surroundings around, Outbox& out) {
    if (proposal_->answers.size() < proposal_->message.view.members.size()) return;
    const Proposal done = *std::exchange(proposal_, std::nullopt);
    const auto serving = around.addresses.claimed();
    const auto ended = around.ended.list();
    const Answers answers{.view = done.message.view,
                          .holdings = done.answers,
                          .serving = serving,
                          .home = around.addresses.home(),
                          .appointed = appointed_,
                          .ended = ended,
                          .leader = self_,
                          .leader_sessions = around.sessions};
    const auto ends = agreed_ends(answers);
    for (const auto& [holder, request] : missing_tails(answers, ends)) {
        if (holder != self_.broker) {
            out.push_back({holder, request});
        } else if (const auto log = around.logs.find(request.after.log); log != around.logs.end()) {
            send_tail(log->second.history(), {log->first, log->second.end()}, request.after.seq,
                      request.to, out);
        }
    }
    ViewAnnouncement announcement{.view = done.message.view,
                                  .assignments = assign(answers, ends, around.membership),
                                  .ends = {}};
    for (const auto& [log, end] : ends) announcement.ends.push_back({log, end});
    for (const LogId& member : announcement.view.members) {
        if (member != self_) out.push_back({member.broker, announcement});
    }
    announced_ = Announced{announcement, now};
    install(now, std::move(announcement), around);
}

/// Nobody has a lease before all members are in the view, and the announcement may be late, or have
/// come before its addressee knew its place.
void ViewChange::announce_again(Instant now, const Membership& membership, Outbox& out) {
    if (!announced_ || announced_->message.view.number != promised_) return announced_.reset();
    if (now < announced_->said_at + membership.times().proposal_kept_for()) return;
    announced_->said_at = now;
    for (const LogId& member : announced_->message.view.members) {
        const Peer* peer = membership.find(member.broker);
        const bool lacks_it = peer != nullptr && peer->beacon.log == member && peer->alive &&
                              peer->beacon.view.number < promised_;
        if (lacks_it) out.push_back({member.broker, announced_->message});
    }
}

// --- a member's side

/// Promises the view and says what we hold, at once or later (model: answer_proposal).
void ViewChange::on_proposal(Instant now, const ViewProposal& proposal, Surroundings around,
                             Outbox& out) {
    const View& view = proposal.view;
    if (!is_newer(view)) return;
    if (must_wait(now, proposal, around)) {
        const auto follows = [&](const View& proposed) {
            return around.membership.leadership().leader == node_of(proposed.number.leader);
        };
        if (early_ && follows(early_->message.view) && !follows(view)) return;
        early_ = EarlyProposal{proposal, is_asked_again(view) ? early_->first : now, now};
        return;
    }
    early_.reset();
    proposal_.reset();
    promise(view, around);
    for (const LogId& id : proposal.removed) {
        const auto log = around.logs.find(id);
        if (log != around.logs.end()) log->second.freeze();
    }
    out.push_back({view.number.leader, holdings(view, around)});
}

/// Until we follow that leader; and, for some time, while somebody whom it leaves out is well to be
/// heard here: then not that one is dead, but the way between the two. And until the leases of
/// those that it leaves out are over.
bool ViewChange::must_wait(Instant now, const ViewProposal& proposal, Surroundings around) {
    const Membership& membership = around.membership;
    const ViewNumber& number = proposal.view.number;
    if (membership.leadership().leader != node_of(number.leader)) return true;
    const bool is_heard = std::ranges::any_of(proposal.removed, [&](const LogId& log) {
        return contains(log) && membership.is_heard_clearly(log, now);
    });
    const bool is_waited_for = !is_asked_again(proposal.view) ||
                               now < early_->first + membership.times().disagreement_lasts();
    return (is_heard && is_waited_for) || !may_promise(now, proposal.view, around);
}

/// The same members, by the same leader; its number may have grown meanwhile.
bool ViewChange::is_asked_again(const View& view) const {
    return early_ && early_->message.view.number.leader == view.number.leader &&
           early_->message.view.members == view.members;
}

void ViewChange::answer_early_proposal(Instant now, Surroundings around, Outbox& out) {
    if (!early_) return;
    if (now > early_->last + around.membership.times().proposal_kept_for()) {
        early_.reset();
    } else if (!must_wait(now, early_->message, around)) {
        const ViewProposal proposal = early_->message;
        on_proposal(now, proposal, around, out);
    }
}

void ViewChange::on_announcement(Instant now, const ViewAnnouncement& announcement,
                                 Surroundings around) {
    const View& view = announcement.view;
    if (!is_newer(view)) return;
    if (view.number != promised_ &&
        around.membership.leadership().leader != node_of(view.number.leader)) {
        return;
    }
    install(now, announcement, around);
}

bool ViewChange::is_newer(const View& view) const {
    return view.contains(self_) && view.number >= promised_ && view.number > view_.number;
}

ViewHoldings ViewChange::holdings(const View& view, Surroundings around) const {
    ViewHoldings answer{.number = view.number};
    answer.cannot_take = around.addresses.cannot_take();
    answer.serving = around.addresses.claimed();
    for (const auto& [id, log] : around.logs) {
        if (view.contains(id) || !log.is_frozen()) continue;
        answer.holds.push_back({id, log.end()});
        if (log.is_outdated()) answer.outdated.push_back(id);
        if (log.is_foreign()) answer.foreign.push_back(id);
        const Seq not_kept = log.applied() - log.history().events_kept();
        if (not_kept > 0) answer.kept_after.push_back({id, not_kept});
        for (const Endpoint& address : log.addresses_left(view)) {
            answer.addresses.push_back({id, address});
        }
    }
    return answer;
}

/// Enters the view (model: install).
void ViewChange::install(Instant now, ViewAnnouncement announcement, Surroundings around) {
    PeerLogs& logs = around.logs;
    view_ = announcement.view;
    around.lease.on_view(now, view_);
    was_replaced_ = false;
    promised_ = view_.number;
    installed_at_ = now;
    for (auto& [id, log] : logs) {
        if (view_.contains(id)) log.thaw();
    }
    for (const LogPosition& end : announcement.ends) {  // also if we did not hear the proposal
        const auto log = logs.find(end.log);
        if (log == logs.end()) continue;
        log->second.freeze();
        log->second.end_at(end.seq, view_.number);
    }
    appointed_.clear();
    for (const Assignment& assignment : announcement.assignments) {
        const auto heir = std::ranges::find(view_.members, assignment.heir, &LogId::broker);
        if (heir != view_.members.end()) appointed_.try_emplace(assignment.address, *heir);
    }
    assert(!installed_ && "a view is taken in the turn that installs it");
    installed_ = std::move(announcement);
}

}  // namespace romano::cluster
