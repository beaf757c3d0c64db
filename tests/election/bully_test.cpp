// The bully algorithm's rules (Garcia-Molina 1982).
#include "election/bully.h"

#include <gtest/gtest.h>

#include "tests/election/electorate.h"

namespace romano::election::bully_test {
namespace {

using namespace std::chrono_literals;

constexpr NodeId n1{1};
constexpr NodeId n2{2};
constexpr NodeId n3{3};
constexpr NodeId n4{4};

std::unique_ptr<Elector> make(const ElectorOptions& options) {
    return std::make_unique<BullyElector>(options);
}

TEST(BullyElector, TheHighestNodeWins) {
    Electorate room(4, 1, make);
    room.run_for(1s);
    EXPECT_TRUE(room.follow({n1, n2, n3, n4}, n4));
}

TEST(BullyElector, TheNextHighestFollowsACrashedLeader) {
    Electorate room(4, 2, make);
    room.run_for(1s);
    room.crash(n4);
    room.run_for(500ms);
    EXPECT_TRUE(room.follow({n1, n2, n3}, n3));
}

TEST(BullyElector, AHigherNodeThatReturnsTakesTheLeadInAHigherTerm) {
    Electorate room(4, 3, make);
    room.run_for(1s);
    room.crash(n4);
    room.run_for(500ms);
    const Term term = room.leadership(n1).term;
    room.start(n4);
    room.run_for(500ms);
    EXPECT_TRUE(room.follow({n1, n2, n3, n4}, n4));
    EXPECT_GT(room.leadership(n1).term, term);
}

TEST(BullyElector, EachSideOfAPartitionHasItsLeaderAndTheHigherOneLeadsAfterTheHeal) {
    Electorate room(4, 4, make);
    room.run_for(1s);
    room.partition({{n1, n4}, {n2, n3}});
    room.run_for(1s);
    EXPECT_TRUE(room.follow({n1, n4}, n4));
    EXPECT_TRUE(room.follow({n2, n3}, n3));
    room.heal();
    room.run_for(1s);
    EXPECT_TRUE(room.follow({n1, n2, n3, n4}, n4));
}

TEST(BullyElector, ALoneNodeLeadsItself) {
    Electorate room(1, 5, make);
    room.run_for(200ms);
    EXPECT_EQ(room.leadership(n1).leader, n1);
}

TEST(BullyElector, SettlesOnTheHighestAfterCrashesAndCuts) {
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Electorate room(4, seed, make);
        Random chaos(seed);
        room.lose(100'000);
        for (int round = 0; round < 20; ++round) {
            std::set<NodeId> left;
            std::set<NodeId> right;
            for (const NodeId node : {n1, n2, n3, n4})
                (chaos.below(2) == 0 ? left : right).insert(node);
            switch (chaos.below(3)) {
                case 0:
                    room.start(NodeId{1 + chaos.below(4)});
                    break;
                case 1:
                    room.partition({left, right});
                    break;
                default:
                    room.heal();
            }
            room.run_for(chaos.between(20ms, 400ms));
        }
        room.lose(0);
        room.heal();
        room.run_for(2s);
        ASSERT_TRUE(room.follow({n1, n2, n3, n4}, n4));
    }
}

}  // namespace
}  // namespace romano::election::bully_test
