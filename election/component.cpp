#include "election/component.h"

#include <algorithm>

namespace romano::election {

ComponentElector::ComponentElector(const ElectorOptions& options)
    : self_(options.self),
      patience_(options.detection_time),
      listens_alone_for_(options.listens_alone_for) {}

void ComponentElector::on_claim(Instant now, const Claim& claim) {
    const NodeId node = claim.rank.id;
    if (node == self_.id) return;
    highest_term_ = std::max(highest_term_, claim.term);

    Rank& rank = rank_of_.try_emplace(node, claim.rank).first->second;
    if (rank != claim.rank) {  // a battery went down
        const Heard moved = heard_.at(rank);
        heard_.erase(rank);
        heard_.insert_or_assign(claim.rank, moved);
        rank = claim.rank;
    }
    const auto [entry, is_new] = heard_.try_emplace(claim.rank, Heard{claim, now});
    if (!is_new) {
        if (leads_itself(entry->second.claim) && !leads_itself(claim)) {
            entry->second.not_leading_since = now;
        }
        entry->second.claim = claim;
    }
    settle(now);
}

void ComponentElector::on_suspect(Instant now, NodeId node) {
    const auto known = rank_of_.find(node);
    if (known == rank_of_.end()) return;
    heard_.erase(known->second);
    rank_of_.erase(node);
    // Whoever followed it has to find that out as well.
    for (auto& [rank, heard] : heard_) heard.not_leading_since = now;
    settle(now);
}

void ComponentElector::on_ballot(Instant, NodeId, const Ballot&) {}

void ComponentElector::on_tick(Instant now) {
    settle(now);
}

Instant ComponentElector::next_wakeup() const {
    return wakeup_;
}

Claim ComponentElector::claim() const {
    return {.rank = self_, .term = leadership_.term, .leader = leadership_.leader};
}

void ComponentElector::settle(Instant now) {
    if (started_at_ == never) started_at_ = now;
    wakeup_ = never;

    for (auto above = heard_.rbegin(); above != heard_.rend() && above->first > self_; ++above) {
        const auto& [claim, not_leading_since] = above->second;
        if (leads_itself(claim)) {
            // Terms only grow: a leader whose term is behind ours hears our claim and raises it.
            if (claim.term > leadership_.term ||
                (claim.term == leadership_.term &&
                 leadership_.leader.value_or(claim.rank.id) == claim.rank.id)) {
                leadership_ = {claim.term, claim.rank.id};
            } else {
                keep_or_lose_leader();
            }
            return;
        }
        // It should lead, or it hears somebody that we do not. In the second case it will not come
        // to us: after some patience we go on without it, and serve our side of the network.
        if (now < not_leading_since + patience_) {
            wakeup_ = not_leading_since + patience_;
            keep_or_lose_leader();
            return;
        }
    }
    const Instant listens_until = started_at_ + (heard_.empty() ? listens_alone_for_ : patience_);
    if (now < listens_until) {
        wakeup_ = listens_until;
        return;
    }
    lead();
}

void ComponentElector::lead() {
    const bool contested = std::ranges::any_of(heard_, [this](const auto& entry) {
        const Claim& claim = entry.second.claim;
        return claim.term > leadership_.term ||
               (claim.term == leadership_.term && claim.leader && claim.leader != self_.id);
    });
    if (leadership_.leader == self_.id && !contested) return;
    highest_term_ = std::max(highest_term_, leadership_.term) + 1;
    leadership_ = {highest_term_, self_.id};
}

void ComponentElector::keep_or_lose_leader() {
    if (!leadership_.leader || leadership_.leader == self_.id) return;
    const auto known = rank_of_.find(*leadership_.leader);
    if (known == rank_of_.end() || !leads_itself(heard_.at(known->second).claim)) {
        leadership_.leader.reset();
    }
}

}  // namespace romano::election
