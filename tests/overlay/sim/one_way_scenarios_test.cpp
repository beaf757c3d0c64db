// Brokers of which one does not hear another, while their clients hear them all, by script.

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "tests/overlay/sim/cluster_scenario.h"

namespace romano::sim::one_way_scenarios_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

class OneWayScenario : public ClusterScenario {
protected:
    static std::vector<std::pair<std::size_t, std::size_t>> all_ways() {
        std::vector<std::pair<std::size_t, std::size_t>> ways;
        for (std::size_t from = 0; from < 3; ++from) {
            for (std::size_t to = 0; to < 3; ++to) {
                if (from != to) ways.emplace_back(from, to);
            }
        }
        return ways;
    }
    [[nodiscard]] std::size_t servers_of(const Endpoint& address) {
        std::size_t count = 0;
        for (std::size_t i = 0; i < world.broker_count(); ++i) {
            count += static_cast<std::size_t>(std::ranges::count(
                world.broker(i).member().cluster().addresses().serving(), address));
        }
        return count;
    }
};

// Beside a broker that it hears, an heir would be silent, and its clients would speak to the heir.
TEST_F(OneWayScenario, WhoIsHeardIsNotTakenOver) {
    add_one_each({Qos::at_least_once, Qos::exactly_once});
    begin();
    publish(true);
    for (const auto& [from, to] : all_ways()) {
        world.cut(from, to);
        world.run_for(2s);
        // Who does not hear the other may serve its address as well; a third one hears both.
        const std::size_t third = 3 - from - to;
        EXPECT_EQ(servers_of(World::service_address(third)), 1U) << from << " -> " << to;
        EXPECT_EQ(servers_of(World::service_address(to)), 1U) << from << " -> " << to;
        world.heal();
        world.run_for(1s);
    }
    expect_nothing_lost();
    expect_nobody_noticed();
}

// Its machine has no time to receive. Alone in a view it would say once more what the others said.
TEST_F(OneWayScenario, WhoHearsNobodyForLessThanTwoDetectionTimesTakesNobodysPlace) {
    add_one_each({Qos::at_least_once, Qos::exactly_once});
    begin();
    publish(true);
    const auto members = world.broker(0).member().view().members;
    for (std::size_t deaf = 0; deaf < 3; ++deaf) {
        world.deafen(deaf);
        world.run_for(world.options().cluster.detection_timeout * 3 / 2);
        const auto peers = world.broker(deaf).member().facts().peers;
        EXPECT_TRUE(std::ranges::none_of(peers, &overlay::PeerFacts::alive));
        world.heal();
        world.run_for(1s);
    }
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(world.broker(i).member().view().members, members) << i;
        EXPECT_EQ(world.broker(i).member().facts().take_overs, 0U) << i;
    }
    expect_all_promises_kept();
    expect_nobody_noticed();
}

// All hear the leader, and so are in one view; the listener's new broker and its home do not meet.
TEST_F(OneWayScenario, WhoRoamsToABrokerThatDoesNotHearItsHomeGoesOnFromTheCopyThere) {
    add("talker", 0, "pose", "", {Qos::at_least_once, Qos::exactly_once});
    Robot& listener = add("listener", 0, "", "pose");
    add("other", 1, "", "pose");
    begin();
    const std::size_t leader = *world.leader();
    publish(true);
    std::size_t home = 0;
    for (const bool both_ways : {false, true}) {
        const std::size_t next = 3 - leader - home;
        ASSERT_NE(leader, home);
        world.run_for(500ms);
        world.cut(home, next);
        if (both_ways) world.cut(next, home);
        world.run_for(300ms);
        listener.roam_to(World::service_address(next));
        listener.publish("hello", Qos::at_least_once);  // so that its broker knows of it
        world.run_for(2s);
        EXPECT_TRUE(world.broker(next).member().broker().image("listener"));
        world.heal();
        world.run_for(1s);
        home = next;
    }
    expect_nothing_lost();
    expect_nobody_noticed();
}

}  // namespace
}  // namespace romano::sim::one_way_scenarios_test
