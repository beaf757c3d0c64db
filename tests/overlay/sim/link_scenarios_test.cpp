// Crashes that a link tells of at once (overlay/link), and what else a lost link may mean.

#include "tests/overlay/sim/cluster_scenario.h"

namespace romano::sim::link_scenarios_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

class LinkScenario : public ClusterScenario {
protected:
    explicit LinkScenario(const ClusterWorldOptions& options = with_links())
        : ClusterScenario(options) {
        add_one_each({Qos::exactly_once});
    }
    static ClusterWorldOptions with_links() {
        ClusterWorldOptions options;
        options.cluster.detector = "link";
        return options;
    }
    [[nodiscard]] bool is_served_by_another_than(std::size_t victim) {
        const auto home = world.home_of("robot" + std::to_string(victim));
        return home && *home != victim;
    }
};

TEST_F(LinkScenario, ACrashIsTakenOverBeforeABeaconIsMissed) {
    begin();
    publish(true);
    for (const std::size_t victim : {*world.leader(), (*world.leader() + 1) % 3}) {
        world.run_for(1s);
        world.broker(victim).crash();
        EXPECT_TRUE(world.run_until([&] { return is_served_by_another_than(victim); }, 9ms, 100us))
            << victim;
        world.run_for(1s);
        world.broker(victim).start();
        EXPECT_TRUE(world.run_until([&] { return !disagreement(world); }, 5s));
    }
    expect_all_promises_kept();
    expect_nobody_noticed();
}

TEST_F(LinkScenario, SilenceIsLeftToTheBeacons) {
    begin();
    publish(true);
    world.run_for(1s);
    const std::size_t victim = (*world.leader() + 1) % 3;
    world.broker(victim).stop();
    world.run_for(world.options().cluster.detection_timeout - 30ms);
    EXPECT_FALSE(is_served_by_another_than(victim));
    EXPECT_TRUE(world.run_until([&] { return is_served_by_another_than(victim); }, 100ms));
    world.broker(victim).go_on();
    world.run_for(2s);
    expect_all_promises_kept();
    expect_nobody_noticed();
}

TEST_F(LinkScenario, AFalseLossIsMendedByBeacons) {
    begin();
    publish(true);
    world.run_for(1s);
    const std::size_t victim = (*world.leader() + 1) % 3;
    for (const std::size_t other : {(victim + 1) % 3, (victim + 2) % 3}) {
        world.peers().break_link(World::broker_node(other), World::broker_node(victim));
    }
    world.run_for(2s);
    expect_all_promises_kept();
    expect_nobody_noticed();
    EXPECT_EQ(world.home_of("robot" + std::to_string(victim)), victim);
}

TEST_F(LinkScenario, AnOrderlyLeaveEndsLikeACrash) {
    begin();
    publish(true);
    world.run_for(1s);
    const std::size_t victim = (*world.leader() + 1) % 3;
    world.broker(victim).leave();
    EXPECT_TRUE(world.run_until([&] { return is_served_by_another_than(victim); }, 9ms, 100us));
    world.run_for(2s);
    expect_all_promises_kept();
    expect_nobody_noticed();
}

class RaftLinkScenario : public LinkScenario {
protected:
    RaftLinkScenario()
        : LinkScenario([] {
              ClusterWorldOptions options = with_links();
              options.cluster.elector = "raft";
              return options;
          }()) {}
};

TEST_F(RaftLinkScenario, ADeadLeaderIsReplacedBeforeABeaconIsMissed) {
    begin();
    publish(true);
    for (int i = 0; i < 3; ++i) {
        world.run_for(1s);
        const std::size_t victim = *world.leader();
        world.broker(victim).crash();
        // Pre-vote, vote, proposal and answer: eight ways of 0.3 ms at most.
        EXPECT_TRUE(world.run_until([&] { return is_served_by_another_than(victim); }, 9ms, 100us))
            << victim;
        world.run_for(1s);
        world.broker(victim).start();
        EXPECT_TRUE(world.run_until([&] { return !disagreement(world); }, 5s));
    }
    expect_all_promises_kept();
    expect_nobody_noticed();
}

}  // namespace
}  // namespace romano::sim::link_scenarios_test
