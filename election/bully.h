// The bully algorithm (Garcia-Molina 1982): the classic baseline. Whoever misses the leader asks
// all higher-ranked nodes; if one answers, it waits for that one's victory, else it declares its
// own.
//
// A node that is higher than the leader takes the lead as soon as it hears of it. Unlike
// `component` it exchanges messages and waits for answers, and unlike `raft` it has a leader on
// each side of a partition.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "election/elector.h"

namespace romano::election {

class BullyElector final : public Elector {
public:
    explicit BullyElector(const ElectorOptions& options);

    void on_claim(Instant now, const Claim& claim) override;
    void on_suspect(Instant now, NodeId node) override;
    void on_ballot(Instant now, NodeId from, const Ballot& ballot) override;
    void on_condition(Instant, std::uint32_t condition) override {
        options_.self.condition = condition;  // whoever outranks us now will say so
    }
    void on_detection_time(Duration time) override { options_.detection_time = time; }
    void on_tick(Instant now) override;
    [[nodiscard]] Instant next_wakeup() const override { return deadline_; }

    [[nodiscard]] Leadership leadership() const override { return {term_, leader_}; }
    [[nodiscard]] Claim claim() const override { return {options_.self, term_, leader_}; }
    [[nodiscard]] std::vector<BallotTo> take_ballots() override;

private:
    enum class Phase : std::uint8_t {
        starting,
        listening,  // the others are unknown to it
        settled,
        asking,   // waits for an answer of a higher node; none by the deadline: victory
        waiting,  // a higher node answered; no victory by the deadline: ask again
    };

    void start_election(Instant now);
    void declare_victory(Instant now);
    void follow(NodeId leader, Term term);
    [[nodiscard]] bool outranks_us(NodeId node) const;

    ElectorOptions options_;
    Phase phase_ = Phase::starting;
    Instant started_at_{};
    Term term_ = 0;
    std::optional<NodeId> leader_;
    std::map<NodeId, Rank> alive_;  // peers, by id
    Instant deadline_ = Instant::min();
    std::vector<BallotTo> outbox_;
};

}  // namespace romano::election
