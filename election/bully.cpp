#include "election/bully.h"

#include <algorithm>
#include <utility>

namespace romano::election {

namespace {

// Kinds of ballots.
constexpr std::uint8_t election = 1;
constexpr std::uint8_t answer = 2;
constexpr std::uint8_t victory = 3;

}  // namespace

BullyElector::BullyElector(const ElectorOptions& options) : options_(options) {}

std::vector<BallotTo> BullyElector::take_ballots() {
    return std::exchange(outbox_, {});
}

bool BullyElector::outranks_us(NodeId node) const {
    const auto peer = alive_.find(node);
    return peer != alive_.end() && peer->second > options_.self;
}

void BullyElector::on_claim(Instant now, const Claim& claim) {
    const NodeId from = claim.rank.id;
    alive_[from] = claim.rank;
    if (claim.leader != from) {
        // A term is only as good as its leader's victory; take note of it, so that ours will be
        // higher.
        term_ = std::max(term_, claim.term);
        return;
    }
    if (claim.rank > options_.self) {
        if (leader_ != from || claim.term > term_) follow(from, std::max(term_, claim.term));
        return;
    }
    // A lower node believes to lead: bully it.
    if (claim.term >= term_ && phase_ == Phase::settled && leader_ == options_.self.id) {
        term_ = claim.term;
        declare_victory(now);
    } else if (phase_ == Phase::settled && leader_ == from) {
        start_election(now);
    }
}

void BullyElector::on_suspect(Instant now, NodeId node) {
    alive_.erase(node);
    if (leader_ == node) {
        leader_.reset();
        start_election(now);
    } else if (phase_ == Phase::asking && std::ranges::none_of(alive_, [&](const auto& peer) {
                   return peer.second > options_.self;
               })) {
        declare_victory(now);
    }
}

void BullyElector::on_tick(Instant now) {
    if (now < deadline_) return;
    if (phase_ == Phase::starting) {
        phase_ = Phase::listening;
        started_at_ = now;
        deadline_ = now + options_.listens_alone_for;
        return;
    }
    const Instant heard_all_at = started_at_ + options_.detection_time;
    if (phase_ == Phase::listening && !alive_.empty() && now < heard_all_at) {
        deadline_ = heard_all_at;
        return;
    }
    if (phase_ == Phase::asking)
        declare_victory(now);
    else if (phase_ == Phase::listening || phase_ == Phase::waiting)
        start_election(now);
}

void BullyElector::start_election(Instant now) {
    phase_ = Phase::asking;
    deadline_ = now + options_.detection_time / 2;
    bool asked = false;
    for (const auto& [id, rank] : alive_) {
        if (rank > options_.self) {
            outbox_.push_back({id, {election, term_}});
            asked = true;
        }
    }
    if (!asked) declare_victory(now);
}

void BullyElector::declare_victory(Instant) {
    phase_ = Phase::settled;
    deadline_ = never;
    ++term_;
    leader_ = options_.self.id;
    for (const auto& [id, rank] : alive_) outbox_.push_back({id, {victory, term_}});
}

void BullyElector::follow(NodeId leader, Term term) {
    phase_ = Phase::settled;
    deadline_ = never;
    leader_ = leader;
    term_ = term;
}

void BullyElector::on_ballot(Instant now, NodeId from, const Ballot& ballot) {
    if (!alive_.contains(from)) return;  // its rank is unknown until its beacon comes
    switch (ballot.kind) {
        case election:
            if (outranks_us(from)) return;
            term_ = std::max(term_, ballot.term);
            outbox_.push_back({from, {answer, term_}});
            if (phase_ == Phase::settled && leader_ == options_.self.id)
                declare_victory(now);
            else if (phase_ == Phase::settled)
                start_election(now);
            return;
        case answer:
            if (phase_ != Phase::asking || !outranks_us(from)) return;
            phase_ = Phase::waiting;
            deadline_ = now + options_.detection_time;
            return;
        case victory:
            term_ = std::max(term_, ballot.term);
            if (outranks_us(from))
                follow(from, term_);
            else if (phase_ == Phase::settled)
                start_election(now);
            return;
        default:
            return;
    }
}

}  // namespace romano::election
