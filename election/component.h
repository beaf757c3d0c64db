// The default election: the highest-ranked live broker of each connected component leads it.
//
// After Vasudevan, Kurose and Towsley 2004, simplified for broadcast beacons: every node hears
// every neighbour's rank and claim all the time, so that no probes or acknowledgements are needed.
// A node that hears nobody above itself claims leadership under a new term; the others follow the
// highest node that claims. No quorum: a component of one node leads itself.
#pragma once

#include "election/elector.h"
#include "romano/base/flat_map.h"

namespace romano::election {

class ComponentElector final : public Elector {
public:
    explicit ComponentElector(const ElectorOptions& options);

    void on_claim(Instant now, const Claim& claim) override;
    void on_suspect(Instant now, NodeId node) override;
    void on_ballot(Instant now, NodeId from, const Ballot& ballot) override;
    void on_condition(Instant now, std::uint32_t condition) override {
        self_.condition = condition;
        settle(now);
    }
    void on_detection_time(Duration time) override { patience_ = time; }
    void on_tick(Instant now) override;
    [[nodiscard]] Instant next_wakeup() const override;
    [[nodiscard]] Leadership leadership() const override { return leadership_; }
    [[nodiscard]] Claim claim() const override;
    [[nodiscard]] std::vector<BallotTo> take_ballots() override { return {}; }

private:
    struct Heard {
        Claim claim;
        Instant not_leading_since;  // meaningful while it does not claim leadership for itself
    };

    void settle(Instant now);
    void lead();
    void keep_or_lose_leader();
    [[nodiscard]] bool leads_itself(const Claim& claim) const {
        return claim.leader == claim.rank.id;
    }

    Rank self_;
    Duration patience_;  // how long a node that should lead is waited for
    Duration listens_alone_for_;
    FlatMap<Rank, Heard> heard_;
    FlatMap<NodeId, Rank> rank_of_;
    Leadership leadership_;
    Term highest_term_ = 0;       // of all claims that were ever heard
    Instant started_at_ = never;  // a starting node first learns who is there
    Instant wakeup_ = Instant::min();
};

}  // namespace romano::election
