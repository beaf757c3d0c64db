// The bridge's core: endpoints of robots as they become known, movements with an end, what goes
// where, and the bounds.

#include "overlay/ros2/bridge_core.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "romano/base/bytes.h"

namespace romano::ros2::bridge_core_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

const Payload location{0x06, 16, 0, 2, 0, 0, 3, 0xE8, 0, 0, 0, 0, 0, 0, 0, 0};  // x 1000 mm
const Payload speed{0x06, 12, 0, 3, 0, 0, 0, 100, 0, 0, 0, 0};                  // 100 mm/s
const Payload battery{0x06, 6, 0, 4, 0x1C, 0xE8};

Payload front(std::uint8_t mm) {
    return {0x07, 8, 0, 0, 0, 0, 0, mm};
}

struct Bridge : testing::Test {
    explicit Bridge(const std::string& rules =
                        "out robots/+/telemetry /robot_+/odom nav_msgs/msg/Odometry\n"
                        "out robots/+/telemetry /robot_+/battery sensor_msgs/msg/BatteryState\n"
                        "out +/move /robot_+/cmd_vel geometry_msgs/msg/Twist speed=0.1\n"
                        "in +/say /robot_+/say std_msgs/msg/String qos=1\n"
                        "both site /site std_msgs/msg/String retained=yes\n")
        : core(parse_rules(rules).value()) {
        core.open(out);
    }

    template <typename Kind>
    std::vector<Kind> take() {
        std::vector<Kind> found;
        for (const auto& action : out) {
            if (const auto* kind = std::get_if<Kind>(&action)) found.push_back(*kind);
        }
        out.clear();
        return found;
    }
    std::vector<std::string> made() {
        std::vector<std::string> names;
        for (const auto& endpoint : take<MakeEndpoint>()) {
            names.push_back((endpoint.writes ? "> " : "< ") + endpoint.topic);
        }
        return names;
    }
    void say(const std::string& topic, const Payload& payload) {
        core.on_romano(now, {topic, payload, 1000}, out);
    }
    void say(const std::string& topic, const std::string& text) {
        const Bytes octets = as_octets(text);
        say(topic, Payload{octets.begin(), octets.end()});
    }
    /// Velocities ahead that were written, as the core's own timer has it.
    std::vector<double> velocities_until(Duration later) {
        std::vector<double> ahead;
        const Instant end = now + later;
        const auto look = [&] {
            for (const auto& message : take<ToRos>()) {
                ahead.push_back(std::get<Twist>(message.message).linear.x);
            }
        };
        look();
        while (core.next_wakeup() <= end) {
            now = core.next_wakeup();
            core.on_tick(now, out);
            look();
        }
        now = end;
        return ahead;
    }

    BridgeCore core;
    std::vector<BridgeAction> out;
    Instant now{};
};

TEST_F(Bridge, HasTheEndpointsOfRulesWithoutWildcardFromTheBeginning) {
    const auto endpoints = take<MakeEndpoint>();
    ASSERT_THAT(endpoints, SizeIs(2));
    EXPECT_EQ(endpoints[0].topic, "/site");
    EXPECT_TRUE(endpoints[0].writes && endpoints[0].retained);
    EXPECT_EQ(endpoints[0].node, bridge_node);
    EXPECT_FALSE(endpoints[1].writes);
}

TEST_F(Bridge, ARobotsFirstMessageMakesAllItsEndpointsUnderItsNode) {
    out.clear();
    say("robots/a1/telemetry", location);
    const auto endpoints = take<MakeEndpoint>();
    ASSERT_THAT(endpoints, SizeIs(4));
    for (const auto& endpoint : endpoints) EXPECT_EQ(endpoint.node, "robot_a1");
    EXPECT_FALSE(endpoints[3].writes);
    EXPECT_EQ(endpoints[3].topic, "/robot_a1/say");
    EXPECT_TRUE(endpoints[3].reliable) << "QoS 1";
    say("robots/a1/telemetry", location);
    EXPECT_THAT(made(), IsEmpty());
}

TEST_F(Bridge, WhatIsOfNoRulesTypeMakesNoRobotKnown) {
    out.clear();
    say("common/move", Payload{0x0C, 2});
    EXPECT_THAT(made(), IsEmpty());
    EXPECT_EQ(core.counters().unfit, 1u);
}

TEST_F(Bridge, AWriterOfRos2MakesTheRobotKnownToo) {
    out.clear();
    const Rule* rule = core.on_ros_writer("/robot_b2/say", out);
    ASSERT_NE(rule, nullptr);
    EXPECT_EQ(rule->line, 4u);
    EXPECT_THAT(made(), ElementsAre("> /robot_b2/odom", "> /robot_b2/battery",
                                    "> /robot_b2/cmd_vel", "< /robot_b2/say"));
    EXPECT_EQ(core.on_ros_writer("/robot_b2/odom", out), nullptr) << "no rule takes that in";
}

TEST_F(Bridge, EachRuleTakesWhatIsOfItsType) {
    say("robots/a1/telemetry", speed);
    EXPECT_THAT(take<ToRos>(), IsEmpty()) << "a speed waits for its location";
    say("robots/a1/telemetry", location);
    const auto places = take<ToRos>();
    ASSERT_THAT(places, SizeIs(1));
    EXPECT_EQ(places[0].topic, "/robot_a1/odom");
    EXPECT_EQ(std::get<Odometry>(places[0].message).twist.linear.x, 0.1);
    say("robots/a1/telemetry", battery);
    const auto batteries = take<ToRos>();
    ASSERT_THAT(batteries, SizeIs(1));
    EXPECT_EQ(batteries[0].topic, "/robot_a1/battery");
    say("robots/a1/telemetry", Payload{1, 2, 3});
    EXPECT_THAT(take<ToRos>(), IsEmpty());
    EXPECT_EQ(core.counters().unfit, 1u);
    EXPECT_EQ(core.counters().to_ros, 2u);
}

TEST_F(Bridge, AMovementIsRepeatedUntilItsEndAndThenStopped) {
    say("a1/move", front(35));  // 350 ms at 0.1 m/s
    EXPECT_THAT(velocities_until(2s), ElementsAre(0.1, 0.1, 0.1, 0.1, 0));
    EXPECT_EQ(core.next_wakeup(), never);
}

TEST_F(Bridge, ANewMovementTakesThePlaceOfTheLast) {
    say("a1/move", front(200));
    EXPECT_THAT(velocities_until(150ms), ElementsAre(0.1, 0.1));
    say("a1/move", front(5));
    EXPECT_THAT(velocities_until(2s), ElementsAre(0.1, 0));
    say("a1/move", front(200));
    say("a1/move", front(0));
    EXPECT_THAT(velocities_until(2s), ElementsAre(0.1, 0));
}

TEST_F(Bridge, WhatADeadBridgeMayHaveSetInMotionIsStopped) {
    out.clear();
    core.take_over("/robot_a1/cmd_vel", out);
    EXPECT_THAT(velocities_until(0s), ElementsAre(0));
    core.take_over("/robot_a1/odom", out);
    EXPECT_THAT(take<ToRos>(), IsEmpty());
}

TEST_F(Bridge, StopsWhatMovesWhenItCloses) {
    say("a1/move", front(200));
    EXPECT_THAT(velocities_until(0s), ElementsAre(0.1));
    core.close(out);
    EXPECT_THAT(velocities_until(2s), ElementsAre(0));
}

TEST_F(Bridge, ComesBackWithoutAnythingOfBefore) {
    say("a1/move", front(200));
    core.close(out);
    EXPECT_EQ(core.next_wakeup(), never);
    out.clear();
    core.open(out);
    EXPECT_THAT(made(), ElementsAre("> /site", "< /site"));
}

TEST_F(Bridge, BringsWhatRos2SaysToItsTopicAtTheRulesQos) {
    core.on_ros("/robot_a1/say", String{"hi"}, out);
    const auto said = take<ToRomano>();
    ASSERT_THAT(said, SizeIs(1));
    EXPECT_EQ(said[0].topic, "a1/say");
    EXPECT_EQ(said[0].payload, (Payload{'h', 'i'}));
    EXPECT_EQ(said[0].qos, mqttsn::Qos::at_least_once);
    EXPECT_FALSE(said[0].retain);
    core.on_ros("/site", String{"kept"}, out);
    EXPECT_TRUE(take<ToRomano>().at(0).retain);
    core.on_ros("/robot_a1/say", Twist{}, out);
    EXPECT_THAT(take<ToRomano>(), IsEmpty()) << "of another type than the rule's";
    EXPECT_EQ(core.counters().unfit, 1u);
}

TEST_F(Bridge, ATopicThatIsNoNameInRos2IsCounted) {
    say("robots/a-1/telemetry", location);
    EXPECT_EQ(core.counters().bad_name, 1u);
}

struct BareNames : Bridge {
    BareNames() : Bridge("out r/+/x /r_+/x std_msgs/msg/String node=+") {}
};

TEST_F(BareNames, ThatAreNoNodesInRos2BelongToTheBridgesOwn) {
    say("r/1a/x", "hi");
    say("r/a1/x", "hi");
    const auto endpoints = take<MakeEndpoint>();
    EXPECT_EQ(endpoints.at(0).node, bridge_node);
    EXPECT_EQ(endpoints.at(1).node, "a1");
}

struct ManyRobots : Bridge {
    ManyRobots()
        : Bridge("out r/+/x /r_+/x std_msgs/msg/String\nin r/+/y /r_+/y std_msgs/msg/String") {}
};

TEST_F(ManyRobots, AreBoundedAndCountedBeyond) {
    constexpr std::size_t most = BridgeCore::most_endpoints / 2;
    for (std::size_t i = 0; i < most + 10; ++i) say("r/" + std::to_string(i) + "/x", "hi");
    EXPECT_EQ(core.endpoints(), BridgeCore::most_endpoints);
    EXPECT_EQ(core.counters().to_ros, most);
    EXPECT_EQ(core.counters().too_many, 10u);
    say("r/0/x", "hi");
    EXPECT_EQ(core.counters().to_ros, most + 1) << "those that are known go on";
}

}  // namespace
}  // namespace romano::ros2::bridge_core_test
