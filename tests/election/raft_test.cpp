// Raft's election rules; sections of the paper (Ongaro and Ousterhout 2014) and of the thesis.
#include "election/raft.h"

#include <gtest/gtest.h>

#include "tests/election/electorate.h"

namespace romano::election::raft_test {
namespace {

using namespace std::chrono_literals;

constexpr NodeId n1{1};
constexpr NodeId n2{2};
constexpr NodeId n3{3};
constexpr NodeId n4{4};
constexpr NodeId n5{5};

std::unique_ptr<Elector> make(const ElectorOptions& options) {
    return std::make_unique<RaftElector>(options);
}

NodeId leader_of(Electorate& room, NodeId witness) {
    return room.leadership(witness).leader.value_or(NodeId{});
}

TEST(RaftElector, ElectsOneLeaderThatAllFollow) {
    Electorate room(5, 1, make);
    room.run_for(1s);
    EXPECT_TRUE(room.follow({n1, n2, n3, n4, n5}, leader_of(room, n1)));
}

TEST(RaftElector, AStableLeaderStays) {  // 5.2: beacons are heartbeats
    Electorate room(5, 2, make);
    room.run_for(1s);
    const Leadership before = room.leadership(n1);
    room.run_for(20s);
    EXPECT_EQ(room.leadership(n1), before);
}

TEST(RaftElector, ReplacesALeaderThatCrashed) {
    Electorate room(5, 3, make);
    room.run_for(1s);
    const NodeId old = leader_of(room, n1);
    const NodeId witness = old == n1 ? n2 : n1;
    const Term term = room.leadership(witness).term;
    room.crash(old);
    room.run_for(500ms);
    EXPECT_NE(leader_of(room, witness), old);
    EXPECT_NE(leader_of(room, witness), NodeId{});
    EXPECT_GT(room.leadership(witness).term, term);
}

/// Where a lost link tells of a death, all voters learn of it at nearly the same time.
void tell_of_death(Electorate& room, NodeId dead, const std::vector<NodeId>& to, Duration apart) {
    for (const NodeId node : to) {
        room.node(node).on_suspect(room.now(), dead);
        room.run_for(apart);
    }
}

TEST(RaftElector, WhenItsLinkIsLostTheNextLeaderIsThereInTwoRoundTrips) {
    for (const Duration apart : {0ms, 2ms, 5ms}) {  // the first to know may ask too early
        for (std::uint64_t seed = 1; seed <= 20; ++seed) {
            Electorate room(3, seed, make);
            room.run_for(1s);
            const NodeId old = leader_of(room, n1);
            std::vector<NodeId> others{n1, n2, n3};
            std::erase(others, old);
            room.crash(old);
            tell_of_death(room, old, others, apart);
            room.run_for(4 * 3ms + 1ms);  // pre-vote, vote: letters take up to 3 ms
            EXPECT_TRUE(room.leadership(others[0]).leader) << "seed " << seed;
            EXPECT_NE(room.leadership(others[0]).leader, old) << "seed " << seed;
        }
    }
}

TEST(RaftElector, AMinorityHasNoLeader) {  // P1; thesis 6.2: a leader without majority steps down
    Electorate room(5, 4, make);
    room.run_for(1s);
    const NodeId old = leader_of(room, n1);
    const NodeId companion = old == n1 ? n2 : n1;
    std::set<NodeId> majority{n1, n2, n3, n4, n5};
    majority.erase(old);
    majority.erase(companion);
    room.partition({{old, companion}, majority});
    room.run_for(2s);
    EXPECT_FALSE(room.leadership(old).leader.has_value());
    EXPECT_FALSE(room.leadership(companion).leader.has_value());
    EXPECT_TRUE(room.follow(majority, leader_of(room, *majority.begin())));
}

// A moment later it would open a view alone, and acknowledge beside the majority.
TEST(RaftElector, ALeaderThatMissesAMajorityStepsDownAtOnce) {
    Electorate room(3, 4, make);
    room.run_for(1s);
    const NodeId leader = leader_of(room, n1);
    std::vector<NodeId> others{n1, n2, n3};
    std::erase(others, leader);
    tell_of_death(room, others[0], {leader}, 0ms);
    EXPECT_EQ(room.leadership(leader).leader, leader) << "two of three are enough";
    tell_of_death(room, others[1], {leader}, 0ms);
    EXPECT_FALSE(room.leadership(leader).leader);
}

TEST(RaftElector, ANodeThatWasCutOffDoesNotRaiseTermsOrDeposeTheLeader) {  // thesis 9.6, pre-vote
    Electorate room(5, 5, make);
    room.run_for(1s);
    const Leadership before = room.leadership(n1);
    const NodeId outsider = before.leader == n5 ? n4 : n5;
    std::set<NodeId> others{n1, n2, n3, n4, n5};
    others.erase(outsider);
    room.partition({{outsider}, others});
    room.run_for(5s);
    EXPECT_EQ(room.leadership(outsider).term, before.term);
    room.heal();
    room.run_for(1s);
    EXPECT_EQ(room.leadership(outsider), before);
    EXPECT_EQ(room.leadership(*others.begin()), before);
}

TEST(RaftElector, TwoOfThreeAreEnoughAndOneIsNot) {
    Electorate room(3, 6, make);
    room.run_for(1s);
    room.crash(leader_of(room, n1));
    room.run_for(1s);
    NodeId alive{};
    for (const NodeId node : {n1, n2, n3}) {
        if (room.leaders_by_term().rbegin()->second.contains(node)) alive = node;
    }
    EXPECT_EQ(room.leadership(alive).leader, alive);
    for (const NodeId node : {n1, n2, n3}) {
        if (node != alive) room.crash(node);
    }
    room.run_for(1s);
    EXPECT_FALSE(room.leadership(alive).leader.has_value());
}

TEST(RaftElector,
     ARestartedVoterDoesNotVoteTwiceInATerm) {  // P1, without a disk: it abstains at first
    RaftElector voter(
        {.self = {1, 0, n1}, .detection_time = detection_time, .voters = {n1, n2, n3}, .seed = 1});
    voter.on_tick(Instant{});
    constexpr std::uint8_t vote_request = 3;
    voter.on_ballot(Instant{} + 10ms, n2, {vote_request, 1});
    for (const auto& answer : voter.take_ballots()) EXPECT_NE(answer.ballot.kind, vote_request + 1);
    voter.on_ballot(Instant{} + 4 * detection_time, n2, {vote_request, 1});
    const auto answers = voter.take_ballots();
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_EQ(answers[0].ballot.kind, vote_request + 1);
    voter.on_ballot(Instant{} + 4 * detection_time, n3, {vote_request, 1});
    EXPECT_NE(voter.take_ballots().at(0).ballot.kind, vote_request + 1) << "one vote a term";
}

TEST(RaftElector, AtMostOneLeaderATermUnderCrashesCutsAndLoss) {  // P1
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Electorate room(5, seed, make);
        Random chaos(seed);
        room.lose(100'000);
        for (int round = 0; round < 20; ++round) {
            const NodeId victim{1 + chaos.below(5)};
            std::set<NodeId> left;
            std::set<NodeId> right;
            for (const NodeId node : {n1, n2, n3, n4, n5})
                (chaos.below(2) == 0 ? left : right).insert(node);
            switch (chaos.below(3)) {
                case 0:
                    room.start(victim);
                    break;
                case 1:
                    room.partition({left, right});
                    break;
                default:
                    room.heal();
            }
            room.run_for(chaos.between(20ms, 400ms));
        }
        for (const auto& [term, leaders] : room.leaders_by_term()) {
            ASSERT_EQ(leaders.size(), 1U) << "term " << term;
        }
        room.lose(0);
        room.heal();
        room.run_for(2s);
        ASSERT_TRUE(room.follow({n1, n2, n3, n4, n5}, leader_of(room, n1)))
            << "liveness once faults stop";
    }
}

}  // namespace
}  // namespace romano::election::raft_test
