#include "election/raft.h"

#include <algorithm>
#include <utility>

namespace romano::election {

namespace {

// Kinds of ballots. A grant repeats the term that it grants.
constexpr std::uint8_t pre_vote_request = 1;
constexpr std::uint8_t pre_vote_grant = 2;
constexpr std::uint8_t vote_request = 3;
constexpr std::uint8_t vote_grant = 4;
constexpr std::uint8_t refusal = 5;  // carries the refuser's term, so that a straggler catches up

}  // namespace

RaftElector::RaftElector(const ElectorOptions& options)
    : options_(options), random_(options.seed) {}

std::vector<BallotTo> RaftElector::take_ballots() {
    return std::exchange(outbox_, {});
}

bool RaftElector::is_voter(NodeId node) const {
    return std::ranges::count(options_.voters, node) > 0;
}

void RaftElector::restart_timeout(Instant now) {
    timeout_ = now + random_.between(options_.detection_time, 2 * options_.detection_time);
}

/// Thesis 4.2.3: whoever heard a leader within the shortest election time-out helps nobody to
/// depose it.
bool RaftElector::hears_leader(Instant now) const {
    return role_ == Role::leader || (leader_ && now - leader_heard_ < options_.detection_time);
}

std::size_t RaftElector::voters_heard(Instant now) const {
    return static_cast<std::size_t>(std::ranges::count_if(options_.voters, [&](NodeId voter) {
        if (voter == options_.self.id) return true;
        const auto heard = heard_.find(voter);
        return heard != heard_.end() && now - heard->second < 2 * options_.detection_time;
    }));
}

void RaftElector::become_follower(Instant now, Term term, std::optional<NodeId> leader) {
    if (term > term_) voted_for_.reset();
    role_ = Role::follower;
    term_ = term;
    leader_ = leader;
    grants_.clear();
    restart_timeout(now);
}

void RaftElector::on_claim(Instant now, const Claim& claim) {
    const NodeId from = claim.rank.id;
    if (is_voter(from)) heard_[from] = now;
    const bool from_leader = claim.leader == from;
    // Also a leader gives way: a higher term passed a majority's pre-vote, and who is in it would
    // else be lost to us.
    if (claim.term > term_) become_follower(now, claim.term, std::nullopt);
    if (from_leader && claim.term == term_ && role_ != Role::leader) {
        if (leader_ != from || role_ != Role::follower) become_follower(now, term_, from);
        leader_heard_ = now;
        restart_timeout(now);
    }
}

/// The voters take turns: the first one asks at once, which is when a lost link told of the
/// leader's death to all of them at the same time. Chance would let two ask at once, or all wait.
void RaftElector::on_suspect(Instant now, NodeId node) {
    heard_.erase(node);
    // A view without a majority would be a leader's alone.
    if (role_ == Role::leader && !is_majority(voters_heard(now))) {
        return become_follower(now, term_, std::nullopt);
    }
    if (leader_ != node || role_ != Role::follower) return;
    leader_.reset();
    timeout_ = std::min(timeout_, now + turn_after(node) * (options_.detection_time / 8));
    answer_early_request(now);
}

std::ptrdiff_t RaftElector::turn_after(NodeId leader) const {
    const auto self = std::ranges::find(options_.voters, options_.self.id);
    return std::count_if(options_.voters.begin(), self,
                         [leader](NodeId voter) { return voter != leader; });
}

void RaftElector::on_tick(Instant now) {
    if (may_vote_at_ == never) {
        may_vote_at_ = now + 4 * options_.detection_time;
        return restart_timeout(now);
    }
    if (now < timeout_) return;
    if (role_ == Role::leader) {
        if (!is_majority(voters_heard(now)))
            become_follower(now, term_, std::nullopt);
        else
            restart_timeout(now);
        return;
    }
    leader_.reset();
    if (!is_voter(options_.self.id) || now < may_vote_at_) {
        restart_timeout(now);
        return;
    }
    start_pre_vote(now);
}

Instant RaftElector::next_wakeup() const {
    return may_vote_at_ == never ? Instant::min() : timeout_;
}

/// Thesis 9.6: first ask whether an election could be won, so that a node that was cut off does not
/// raise terms.
void RaftElector::start_pre_vote(Instant now) {
    role_ = Role::pre_candidate;
    grants_ = {options_.self.id};
    restart_timeout(now);
    if (is_majority(grants_.size())) return start_vote(now);
    ask_voters(pre_vote_request, term_ + 1);
}

void RaftElector::start_vote(Instant now) {
    role_ = Role::candidate;
    ++term_;
    voted_for_ = options_.self.id;
    grants_ = {options_.self.id};
    restart_timeout(now);
    if (is_majority(grants_.size())) return become_leader(now);
    ask_voters(vote_request, term_);
}

void RaftElector::become_leader(Instant now) {
    role_ = Role::leader;
    leader_ = options_.self.id;
    // Whoever granted its vote was heard, by way of the ballot.
    for (const NodeId voter : grants_) heard_[voter] = now;
    grants_.clear();
    restart_timeout(now);
}

void RaftElector::ask_voters(std::uint8_t kind, Term term) {
    for (const NodeId voter : options_.voters) {
        if (voter != options_.self.id) outbox_.push_back({voter, {kind, term}});
    }
}

void RaftElector::on_ballot(Instant now, NodeId from, const Ballot& ballot) {
    if (!is_voter(from) || from == options_.self.id) return;
    switch (ballot.kind) {
        case pre_vote_request:
        case vote_request:
            return answer_request(now, from, ballot);
        case pre_vote_grant:
        case vote_grant:
            return count_grant(now, from, ballot);
        case refusal:
            if (ballot.term > term_) become_follower(now, ballot.term, std::nullopt);
            return;
        default:
            return;
    }
}

void RaftElector::answer_request(Instant now, NodeId from, const Ballot& ballot) {
    const bool pre_vote = ballot.kind == pre_vote_request;
    if (now < may_vote_at_ || hears_leader(now)) {
        if (pre_vote) early_ = EarlyRequest{from, ballot, now};
        outbox_.push_back({from, {refusal, term_}});
        return;
    }
    if (!pre_vote && ballot.term > term_) become_follower(now, ballot.term, std::nullopt);
    const bool free_to_vote = pre_vote
                                  ? ballot.term > term_
                                  : ballot.term == term_ && (!voted_for_ || voted_for_ == from);
    if (!free_to_vote) {
        outbox_.push_back({from, {refusal, term_}});
        return;
    }
    if (!pre_vote) {
        voted_for_ = from;
        restart_timeout(now);
    }
    outbox_.push_back({from, {pre_vote ? pre_vote_grant : vote_grant, ballot.term}});
}

void RaftElector::answer_early_request(Instant now) {
    if (!early_) return;
    const EarlyRequest early = *std::exchange(early_, std::nullopt);
    if (now < early.at + options_.detection_time) answer_request(now, early.from, early.ballot);
}

void RaftElector::count_grant(Instant now, NodeId from, const Ballot& ballot) {
    const bool for_pre_vote =
        role_ == Role::pre_candidate && ballot.kind == pre_vote_grant && ballot.term == term_ + 1;
    const bool for_vote =
        role_ == Role::candidate && ballot.kind == vote_grant && ballot.term == term_;
    if (!for_pre_vote && !for_vote) return;
    grants_.insert(from);
    if (!is_majority(grants_.size())) return;
    if (for_pre_vote)
        start_vote(now);
    else
        become_leader(now);
}

}  // namespace romano::election
