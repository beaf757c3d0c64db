// A cluster of shipped members and robots that know one address each: the faults that the design
// names, one by one, by script. What a robot noticed is told by connects(): 1 means nothing.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "overlay/sim/cluster_world.h"
#include "overlay/sim/promises.h"
#include "overlay/sim/settlement.h"
#include "romano/mqttsn/codec.h"
#include "tests/overlay/sim/traced.h"

namespace romano::sim {
namespace {

using namespace std::chrono_literals;
using mqttsn::MsgType;
using mqttsn::Qos;

class ClusterScenario : public testing::Test {
protected:
    ClusterScenario() { trace_if_asked(world); }

    Robot& add(const std::string& name, std::size_t home, const std::string& topic,
               const std::string& filter, std::vector<Qos> qos = {Qos::exactly_once}) {
        RobotOptions options;
        options.name = name;
        options.broker = World::service_address(home);
        if (!topic.empty()) options.topics = {topic};
        if (!filter.empty()) options.subscriptions = {{filter, Qos::exactly_once}};
        options.qos = std::move(qos);
        options.publish_every_min = 10ms;
        options.publish_every_max = 30ms;
        return world.add_robot(options);
    }

    /// Brokers and robots are up, agree and are idle.
    void begin() {
        world.start_brokers();
        ASSERT_TRUE(world.run_until([&] { return !disagreement(world); }, 5s))
            << *disagreement(world);
        for (std::size_t i = 0; i < world.robot_count(); ++i) world.robot(i).start();
        ASSERT_TRUE(world.run_until([&] { return world.robots_are_idle(); }, 5s));
    }

    void publish(bool on) {
        for (std::size_t i = 0; i < world.robot_count(); ++i) {
            on ? world.robot(i).begin_publishing() : world.robot(i).end_publishing();
        }
    }

    /// Publishing ends, all comes to rest, and every promise was kept.
    void expect_all_promises_kept() {
        publish(false);
        EXPECT_TRUE(
            world.run_until([&] { return world.robots_are_idle() && !disagreement(world); }, 20s));
        world.run_for(5s);
        Violations violations = world.violations();
        judge_safety(world.ledger(), {}, violations);
        judge_completeness(world.ledger(), violations);
        judge_settlement(world, violations);
        EXPECT_EQ(to_text(violations), "");
    }

    void expect_nobody_noticed() {
        for (std::size_t i = 0; i < world.robot_count(); ++i) {
            EXPECT_EQ(world.robot(i).connects(), 1U) << world.robot(i).name();
        }
    }

    ClusterWorld world{ClusterWorldOptions{}};  // three brokers
};

TEST_F(ClusterScenario, PublishesCrossBrokers) {
    add("talker", 0, "pose", "", {Qos::at_least_once, Qos::exactly_once});
    add("listener", 1, "", "pose");
    add("other", 2, "", "#");
    begin();
    publish(true);
    world.run_for(2s);
    expect_all_promises_kept();
    expect_nobody_noticed();
    EXPECT_GT(world.ledger().receptions.size(), 100U);
}

TEST_F(ClusterScenario, HomeDiesWhileQos1IsInFlight) {
    add("talker", 0, "pose", "", {Qos::at_least_once});
    add("listener", 1, "", "pose");
    add("neighbour", 0, "", "pose");
    begin();
    publish(true);
    world.run_for(1s);
    world.broker(0).crash();
    world.run_for(3s);
    expect_all_promises_kept();
    expect_nobody_noticed();
}

TEST_F(ClusterScenario, LeaderDies) {
    for (std::size_t home : {0U, 1U, 2U}) {
        add("robot" + std::to_string(home), home, "pose", "pose");
    }
    begin();
    publish(true);
    world.run_for(1s);
    const std::size_t leader = world.leader().value();
    world.broker(leader).crash();
    world.run_for(3s);
    EXPECT_NE(world.leader(), leader);
    expect_all_promises_kept();
    expect_nobody_noticed();
}

TEST_F(ClusterScenario, HomeDiesBetweenPubrecAndPubrelOfItsPublisher) {
    Robot& talker = add("talker", 0, "", "");
    add("listener", 1, "", "pose");
    add("neighbour", 0, "", "pose");
    begin();
    world.clients().set_filter([&](const Endpoint&, const Endpoint& to, Bytes datagram) {
        const auto frame = mqttsn::decode_frame(datagram);
        if (!frame || frame->type != MsgType::pubrel || to != World::service_address(0)) {
            return false;
        }
        if (!world.broker(0).is_up()) return false;
        world.broker(0).crash();
        return true;
    });
    talker.publish("pose", Qos::exactly_once);
    world.run_for(3s);
    EXPECT_FALSE(world.broker(0).is_up());
    expect_all_promises_kept();
    expect_nobody_noticed();
}

TEST_F(ClusterScenario, HomeDiesBetweenPubrecAndPubrelOfItsSubscriber) {
    Robot& talker = add("talker", 1, "", "");
    Robot& listener = add("listener", 0, "", "pose");
    begin();
    bool recorded = false;
    world.clients().set_filter([&](const Endpoint& from, const Endpoint& to, Bytes datagram) {
        const auto frame = mqttsn::decode_frame(datagram);
        if (!frame) return false;
        recorded =
            recorded || (frame->type == MsgType::pubrec && from == listener.options().address);
        if (!recorded || frame->type != MsgType::pubrel || to != listener.options().address) {
            return false;
        }
        if (!world.broker(0).is_up()) return false;
        world.events().after(0s, [&] { world.broker(0).crash(); });
        return true;
    });
    talker.publish("pose", Qos::exactly_once);
    world.run_for(3s);
    EXPECT_FALSE(world.broker(0).is_up());
    expect_all_promises_kept();
    expect_nobody_noticed();
}

TEST_F(ClusterScenario, BrokerIsRestartedBeforeItsPeersMissedIt) {
    add("talker", 0, "pose", "");
    add("listener", 0, "", "pose");
    begin();
    publish(true);
    world.run_for(1s);
    world.broker(0).crash();
    world.run_for(20ms);
    world.broker(0).start();
    world.run_for(3s);
    expect_all_promises_kept();
    expect_nobody_noticed();
}

TEST_F(ClusterScenario, OneAfterAnotherDiesUntilOneIsLeft) {
    for (std::size_t home : {0U, 1U, 2U}) {
        add("robot" + std::to_string(home), home, "pose", "pose",
            {Qos::at_least_once, Qos::exactly_once});
    }
    begin();
    publish(true);
    for (std::size_t victim : {0U, 2U}) {
        world.run_for(1s);
        world.broker(victim).crash();
    }
    world.run_for(3s);
    expect_all_promises_kept();
    expect_nobody_noticed();
}

TEST_F(ClusterScenario, RollingRestartUnderLoad) {
    for (std::size_t home : {0U, 1U, 2U}) {
        add("robot" + std::to_string(home), home, "pose", "pose",
            {Qos::at_least_once, Qos::exactly_once});
    }
    begin();
    publish(true);
    for (std::size_t victim : {0U, 1U, 2U}) {
        world.run_for(1s);
        world.broker(victim).leave();
        world.run_for(500ms);
        world.broker(victim).start();
        world.run_for(1s);
    }
    expect_all_promises_kept();
    expect_nobody_noticed();
}

TEST_F(ClusterScenario, WillOfASilentClientIsPublishedOnceThoughItsHomeDied) {
    RobotOptions mortal;
    mortal.name = "mortal";
    mortal.will_topic = "wills";
    mortal.keep_alive = 3s;
    Robot& dies = world.add_robot(mortal);
    add("watcher", 1, "", "wills");
    add("neighbour", 0, "", "wills");
    begin();
    dies.switch_off();
    world.run_for(1s);
    world.broker(0).crash();
    world.run_for(10s);
    EXPECT_EQ(world.ledger().wills.size(), 2U);  // the watcher's and the neighbour's
    expect_all_promises_kept();
}

TEST_F(ClusterScenario, NoWillIsPublishedBecauseAHomeDied) {
    RobotOptions mortal;
    mortal.name = "mortal";
    mortal.will_topic = "wills";
    mortal.keep_alive = 3s;
    world.add_robot(mortal);
    add("watcher", 1, "", "wills");
    begin();
    world.broker(0).crash();
    world.run_for(10s);
    world.broker(0).start();
    world.run_for(10s);
    EXPECT_TRUE(world.ledger().wills.empty());
    expect_nobody_noticed();
}

TEST_F(ClusterScenario, RetainedMessagesAreTheSameEverywhereAfterAHeal) {
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
