// Brokers that cannot hear each other for a while, and meet again, by script.

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/overlay/sim/cluster_scenario.h"

namespace romano::sim {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

using HealScenario = ClusterScenario;

TEST_F(HealScenario, RetainedMessagesAreTheSameEverywhereAfterAHeal) {
    Robot& left = add("left", 0, "", "");
    Robot& right = add("right", 1, "", "");
    begin();
    world.part({{0}, {1, 2}}, true);
    world.run_for(1s);
    left.publish("pose", Qos::at_least_once, true);
    left.publish("only left", Qos::at_least_once, true);
    world.run_for(1s);
    right.publish("pose", Qos::at_least_once, true);
    right.publish("only right", Qos::at_least_once, true);
    world.run_for(1s);
    world.heal();
    world.run_for(3s);
    expect_all_promises_kept();
    const auto retained = world.broker(0).member().broker().retained();
    ASSERT_EQ(retained.size(), 3U);
    const auto pose =
        std::ranges::find(retained, "pose", [](const broker::MessagePtr& m) { return m->topic; });
    EXPECT_EQ((*pose)->position.log.broker, world.broker(1).id());
}

}  // namespace
}  // namespace romano::sim
