#include "overlay/cluster/agreement/leaderless.h"

#include <gmock/gmock.h>

#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::leaderless_test {
namespace {

using namespace two_brokers;

TEST(Leaderless, IsToldOfAgainAndAgainWithoutALeader) {
    Leaderless leaderless;
    int told = 0;
    for (Instant now{}; now <= Instant{35s}; now += 10ms) {
        told += leaderless.is_to_be_told(now, 10s, false) ? 1 : 0;
    }
    EXPECT_EQ(told, 3);
}

TEST(Leaderless, ALeaderMeanwhileBeginsTheTimeAnew) {
    Leaderless leaderless;
    EXPECT_FALSE(leaderless.is_to_be_told(Instant{1s}, 10s, false));
    EXPECT_FALSE(leaderless.is_to_be_told(Instant{9s}, 10s, true));
    EXPECT_FALSE(leaderless.is_to_be_told(Instant{18s}, 10s, false));
    EXPECT_TRUE(leaderless.is_to_be_told(Instant{19s}, 10s, false));
}

TEST(Leaderless, RaftWithoutAMajorityOfItsVotersIsWarnedOf) {
    ClusterOptions options;
    options.elector = "raft";
    options.voters = {"self", "r2", "r3"};
    Cluster cluster{options};
    for (int i = 0; i < 1'500; ++i, cluster.now += 10ms) cluster.tick();
    ASSERT_EQ(cluster.local.size(), 1U);
    const auto& notice = std::get<Notice>(cluster.local.front());
    EXPECT_TRUE(notice.is_warning);
    EXPECT_THAT(notice.text, testing::HasSubstr("no peer is heard"));
    EXPECT_THAT(notice.text, testing::HasSubstr("needs 2 of the voters self, r2, r3"));
}

TEST(Leaderless, ABrokerThatLeadsItselfIsSilent) {
    Cluster cluster;
    for (int i = 0; i < 1'500; ++i, cluster.now += 10ms) cluster.tick();
    for (const auto& action : cluster.local) {
        const auto* notice = std::get_if<Notice>(&action);
        EXPECT_TRUE(notice == nullptr || !notice->is_warning);
    }
}

}  // namespace
}  // namespace romano::cluster::leaderless_test
