// A broker that starts alone serves soon: its clients wait for who is not there no longer than it
// takes to find out.

#include <gtest/gtest.h>

#include "overlay/cluster/agreement/heartbeat.h"
#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::lone_newcomer_test {
namespace {

using namespace two_brokers;

/// The times of the profile `mesh`.
ClusterOptions mesh(const std::string& elector) {
    ClusterOptions options;
    options.elector = elector;
    options.beacon_every = 1s;
    options.detection_timeout = 6s;
    options.found_again_within = 500ms;
    return options;
}

class LoneNewcomer : public testing::TestWithParam<const char*> {
protected:
    /// How long it takes to its first view, from its first turn.
    Duration until_a_view() {
        const Instant start = cluster.now;
        while (cluster.core.view().members.empty() && cluster.now < start + 60s) cluster.pass();
        return cluster.now - start;
    }
    Cluster cluster{mesh(GetParam())};
};

TEST_P(LoneNewcomer, ServesAfterThreeHeartbeatsAndTheTimeOfDiscovery) {
    EXPECT_LE(until_a_view(), 3 * 1s + 1s + 50ms);
}

// I1, P3: who was heard once may be home to its clients, and its heartbeats be lost for a while.
TEST_P(LoneNewcomer, ListensLongerWhenItHeardOfSomebody) {
    cluster.take(Beacon{.name = "peer", .log = peer, .tick = 1});
    EXPECT_GE(until_a_view(), 2 * 6s);
}

INSTANTIATE_TEST_SUITE_P(Electors, LoneNewcomer, testing::Values("component", "bully"));

}  // namespace
}  // namespace romano::cluster::lone_newcomer_test
