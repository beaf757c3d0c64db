// Raft's leader election (Ongaro and Ousterhout 2014; thesis chapters 3 and 9.6) without its log:
// terms, votes of a majority of the configured voters, pre-vote, and a leader that steps down when
// it hears no majority.
//
// A side of a partition that holds no majority has no leader; at most one leader per term (promise
// P1). Beacons are the heartbeats. Votes are not written to disk: a voter that starts abstains
// until every vote that it may have given before is void, that is for two of the longest election
// time-outs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "election/elector.h"
#include "romano/base/random.h"

namespace romano::election {

class RaftElector final : public Elector {
public:
    /// `options.voters` must name the node itself, else it only follows. Time-outs are drawn from
    /// one to two detection times.
    explicit RaftElector(const ElectorOptions& options);

    void on_claim(Instant now, const Claim& claim) override;
    void on_suspect(Instant now, NodeId node) override;
    void on_ballot(Instant now, NodeId from, const Ballot& ballot) override;
    void on_condition(Instant, std::uint32_t condition) override {
        options_.self.condition = condition;
    }
    void on_detection_time(Duration time) override { options_.detection_time = time; }
    void on_tick(Instant now) override;
    [[nodiscard]] Instant next_wakeup() const override;

    [[nodiscard]] Leadership leadership() const override { return {term_, leader_}; }
    [[nodiscard]] Claim claim() const override { return {options_.self, term_, leader_}; }
    [[nodiscard]] std::vector<BallotTo> take_ballots() override;

private:
    enum class Role : std::uint8_t { follower, pre_candidate, candidate, leader };

    void become_follower(Instant now, Term term, std::optional<NodeId> leader);
    void start_pre_vote(Instant now);
    void start_vote(Instant now);
    void become_leader(Instant now);
    void answer_request(Instant now, NodeId from, const Ballot& ballot);
    void answer_early_request(Instant now);
    void count_grant(Instant now, NodeId from, const Ballot& ballot);
    void ask_voters(std::uint8_t kind, Term term);
    void restart_timeout(Instant now);
    /// This node's place among the voters, when `leader` is not counted.
    [[nodiscard]] std::ptrdiff_t turn_after(NodeId leader) const;
    [[nodiscard]] bool is_voter(NodeId node) const;
    [[nodiscard]] bool is_majority(std::size_t count) const {
        return 2 * count > options_.voters.size();
    }
    [[nodiscard]] bool hears_leader(Instant now) const;
    [[nodiscard]] std::size_t voters_heard(Instant now) const;

    ElectorOptions options_;
    Random random_;
    Role role_ = Role::follower;
    Term term_ = 0;
    std::optional<NodeId> leader_;
    std::optional<NodeId> voted_for_;  // in term_
    std::set<NodeId> grants_;          // of the pre-vote or vote that runs
    std::map<NodeId, Instant> heard_;  // last sign of each voter: a leader must hear a majority
    Instant leader_heard_;             // last claim of leader_ itself
    Instant timeout_ = never;      // the next election; of a leader: the next look at its majority
    Instant may_vote_at_ = never;  // set by the first tick
    std::vector<BallotTo> outbox_;

    /// We refused this pre-vote because of the leader: its sender noticed before us that the leader
    /// is gone. We answer again as soon as we notice.
    struct EarlyRequest {
        NodeId from;
        Ballot ballot;
        Instant at;
    };
    std::optional<EarlyRequest> early_;
};

}  // namespace romano::election
