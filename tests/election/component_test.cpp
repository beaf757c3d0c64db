// Nodes that hear each other's claims every 10 ms over links that a test cuts. P1 of the design:
// each connected component settles on exactly one leader, its highest-ranked node.

#include "election/component.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <utility>

namespace romano::election::component_test {
namespace {

using namespace std::chrono_literals;

constexpr auto beacon = 10ms;
constexpr auto detection = 50ms;

class Neighbourhood {
public:
    void start(int rank) {
        terms_.erase(rank);
        const NodeId id{static_cast<std::uint64_t>(rank)};
        const Rank self{.capability = static_cast<std::uint32_t>(rank), .id = id};
        nodes_.emplace(rank, Node{ComponentElector{{.self = self,
                                                    .detection_time = detection,
                                                    .listens_alone_for = detection}},
                                  {}});
    }
    void kill(int rank) { nodes_.erase(rank); }
    void cut(int a, int b) { cut_.insert(std::minmax(a, b)); }
    void heal() { cut_.clear(); }

    void run_for(Duration time) {
        for (const Instant end = now_ + time; now_ < end; now_ += beacon) step();
    }

    Leadership of(int rank) { return nodes_.at(rank).elector.leadership(); }
    int leader_of(int rank) {
        const auto leader = of(rank).leader;
        return leader ? static_cast<int>(*leader) : 0;
    }
    Term highest_term_seen() const { return highest_term_; }

private:
    struct Node {
        ComponentElector elector;
        std::map<int, Instant> heard;
    };

    void step() {
        for (auto& [from, sender] : nodes_) {
            const Claim claim = sender.elector.claim();
            for (auto& [to, receiver] : nodes_) {
                if (from == to || cut_.contains(std::minmax(from, to))) continue;
                receiver.heard[from] = now_;
                receiver.elector.on_claim(now_, claim);
            }
        }
        for (auto& [rank, node] : nodes_) {
            std::erase_if(node.heard, [&, &elector = node.elector](const auto& entry) {
                if (now_ - entry.second < detection) return false;
                elector.on_suspect(now_, NodeId{static_cast<std::uint64_t>(entry.first)});
                return true;
            });
            node.elector.on_tick(now_);
            EXPECT_GE(node.elector.leadership().term, terms_[rank]) << "terms only grow";
            terms_[rank] = node.elector.leadership().term;
            highest_term_ = std::max(highest_term_, terms_[rank]);
        }
    }

    std::map<int, Node> nodes_;
    std::set<std::pair<int, int>> cut_;
    std::map<int, Term> terms_;
    Term highest_term_ = 0;
    Instant now_{};
};

TEST(ComponentElector, P1_TheHighestRankedLeadsAndAllAgreeOnItsTerm) {
    Neighbourhood nodes;
    for (const int rank : {1, 2, 3, 4, 5}) nodes.start(rank);
    nodes.run_for(300ms);
    for (const int rank : {1, 2, 3, 4, 5}) {
        EXPECT_EQ(nodes.leader_of(rank), 5);
        EXPECT_EQ(nodes.of(rank).term, nodes.of(5).term);
    }
}

TEST(ComponentElector, AStartingNodeListensBeforeItLeads) {
    Neighbourhood nodes;
    nodes.start(1);
    nodes.run_for(30ms);
    EXPECT_EQ(nodes.leader_of(1), 0);
    nodes.run_for(100ms);
    EXPECT_EQ(nodes.leader_of(1), 1);
}

TEST(ComponentElector, P1_WhenTheLeaderDiesTheNextLeadsUnderAHigherTerm) {
    Neighbourhood nodes;
    for (const int rank : {1, 2, 3}) nodes.start(rank);
    nodes.run_for(300ms);
    const Term before = nodes.of(1).term;
    nodes.kill(3);
    nodes.run_for(detection + 3 * beacon);
    EXPECT_EQ(nodes.leader_of(1), 2);
    EXPECT_EQ(nodes.leader_of(2), 2);
    EXPECT_GT(nodes.of(1).term, before);
}

TEST(ComponentElector, ADyingLeaderDoesNotMakeTheLowerOnesClaimInBetween) {
    Neighbourhood nodes;
    for (const int rank : {1, 2, 3}) nodes.start(rank);
    nodes.run_for(300ms);
    const Term before = nodes.highest_term_seen();
    nodes.kill(3);
    nodes.run_for(300ms);
    EXPECT_EQ(nodes.highest_term_seen(), before + 1);
}

TEST(ComponentElector, P1_EachSideOfAPartitionHasItsLeader) {
    Neighbourhood nodes;
    for (const int rank : {1, 2, 3, 4}) nodes.start(rank);
    nodes.run_for(300ms);
    for (const int left : {1, 3}) {
        for (const int right : {2, 4}) nodes.cut(left, right);
    }
    nodes.run_for(300ms);
    EXPECT_EQ(nodes.leader_of(1), 3);
    EXPECT_EQ(nodes.leader_of(2), 4);
}

TEST(ComponentElector, P1_AfterAHealTheHighestLeadsUnderATermAboveBoth) {
    Neighbourhood nodes;
    for (const int rank : {1, 2, 3}) nodes.start(rank);
    nodes.run_for(300ms);
    for (const int rank : {1, 2}) nodes.cut(rank, 3);
    nodes.run_for(300ms);
    const Term left = nodes.of(1).term;  // a new leader there: a higher term than the right's
    EXPECT_GT(left, nodes.of(3).term);
    nodes.heal();
    nodes.run_for(200ms);
    for (const int rank : {1, 2, 3}) {
        EXPECT_EQ(nodes.leader_of(rank), 3);
        EXPECT_GT(nodes.of(rank).term, left);
    }
}

TEST(ComponentElector, AReturningHighestTakesTheLeadBack) {
    Neighbourhood nodes;
    for (const int rank : {1, 2, 3}) nodes.start(rank);
    nodes.run_for(300ms);
    nodes.kill(3);
    nodes.run_for(300ms);
    nodes.start(3);
    nodes.run_for(300ms);
    EXPECT_EQ(nodes.leader_of(1), 3);
    EXPECT_EQ(nodes.leader_of(3), 3);
}

TEST(ComponentElector, AQuietComponentKeepsItsTerm) {
    Neighbourhood nodes;
    for (const int rank : {1, 2, 3}) nodes.start(rank);
    nodes.run_for(300ms);
    const Term before = nodes.of(2).term;
    nodes.run_for(10s);
    EXPECT_EQ(nodes.of(2).term, before);
}

TEST(ComponentElector, ANodeWhoseNeighbourFollowsAStrangerLeadsItself) {
    // 1 hears 2 only, 2 hears both: 3 cannot lead 1, to whom it cannot speak.
    Neighbourhood nodes;
    for (const int rank : {1, 2, 3}) nodes.start(rank);
    nodes.cut(1, 3);
    nodes.run_for(500ms);
    EXPECT_EQ(nodes.leader_of(3), 3);
    EXPECT_EQ(nodes.leader_of(2), 3);
    EXPECT_EQ(nodes.leader_of(1), 1);
}

// phi-accrual changes the detection time: a node above that leads nobody is waited for by what it
// is now.
TEST(ComponentElector, WaitsForAHigherNodeByTheDetectionTimeAsOfNow) {
    ComponentElector elector{{.self = {.capability = 1, .id = NodeId{1}},
                              .detection_time = detection,
                              .listens_alone_for = detection}};
    elector.on_detection_time(3 * detection);
    elector.on_claim(Instant{},
                     {.rank = {.capability = 2, .id = NodeId{2}}, .term = 0, .leader = {}});
    elector.on_tick(Instant{3 * detection - 1ms});
    EXPECT_EQ(elector.leadership().leader, std::nullopt);
    elector.on_tick(Instant{3 * detection});
    EXPECT_EQ(elector.leadership().leader, NodeId{1});
}

}  // namespace
}  // namespace romano::election::component_test
