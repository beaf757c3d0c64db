// The bridge to ROS 2 under load: a burst from there, many robots, a side that stands still.

#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <iostream>

#include "tests/system/metrics_page.h"
#include "tests/system/ros2_fixture.h"

namespace romano::system::ros2_load_test {
namespace {

using namespace ros2;

struct Ros2Load : Ros2 {};

/// As when a recording is played as fast as it can be: what is too much is dropped and counted, and
/// robots talk meanwhile.
TEST_F(Ros2Load, ABurstOfRos2HoldsNoRobotUp) {
    BrokerProcess& broker = start(1, "in say/+ /say_+ std_msgs/msg/String qos=1\n");
    ASSERT_TRUE(wait_for_trace(broker, "ros2: bridged here")) << broker.errors();
    const auto robot = client("robot");
    ASSERT_TRUE(robot->subscribe("say/#", Qos::at_least_once));
    const auto player = peer({"pub", "String", "/say_a", "reliable", "20000", "0", "%", "pub",
                              "String", "/say_b", "reliable", "20000", "0", "%"});
    ASSERT_TRUE(robot->run_until([&] { return robot->received.size() >= 100; }));
    const auto other = client("other");
    const auto topic = other->register_topic("robots/a1/text");
    ASSERT_TRUE(topic);
    for (int i = 0; i < 20; ++i) {
        ASSERT_TRUE(other->publish(*topic, "meanwhile", Qos::exactly_once)) << i;
    }
    const auto late = peer({"pub", "String", "/say_c", "reliable", "200", "100", "last"});
    EXPECT_TRUE(robot->run_until([&] {
        return std::ranges::any_of(robot->received,
                                   [](const auto& message) { return message.data == "last"; });
    })) << "the bridge goes on after the burst";
    std::map<std::string, std::vector<int>> numbers;
    for (const auto& message : robot->received) {
        if (message.data != "last") numbers[message.topic].push_back(std::stoi(message.data));
    }
    for (const auto& [name, all] : numbers) {
        EXPECT_TRUE(std::ranges::is_sorted(all)) << name;
    }
    std::cout << "of 40000 in a burst came " << robot->received.size() - 1 << std::endl;
}

TEST_F(Ros2Load, AThousandRobotsAreBridgedAndOneMoreIsHeard) {
    BrokerProcess& broker = start(1, robots, {"--metrics", metrics()});
    ASSERT_TRUE(wait_for_trace(broker, "ros2: bridged here")) << broker.errors();
    const auto fleet = client("fleet");
    constexpr int count = 1'000;
    const auto id = [](int number) { return "r" + std::to_string(number); };
    for (int i = 0; i < count; ++i) {
        publish(*fleet, "robots/" + id(i) + "/telemetry", location, Qos::at_most_once);
    }
    const auto metrics_at = *net::parse_endpoint(metrics());
    EXPECT_TRUE(metrics_come_to_say(metrics_at, "romano_ros2_endpoints", 6 * count, 6 * count));
    const auto seen = peer({"sub", "Odometry", "/robot_r999/odom", "reliable", "sub", "String",
                            "/robot_last/text", "reliable"});
    publish_until(*fleet, *seen, "robots/r999/telemetry", location, "got /robot_r999/odom");
    publish_until(*fleet, *seen, "robots/last/text", "hello", "got /robot_last/text hello");
}

TEST_F(Ros2Load, ASideThatStandsStillHoldsNoRobotUp) {
    BrokerProcess& broker = start(1, robots, {"--metrics", metrics()});
    ASSERT_TRUE(wait_for_trace(broker, "ros2: bridged here")) << broker.errors();
    const auto robot = client("robot");
    publish(*robot, "robots/a1/text", "hi");
    const auto seen = peer({"sub", "UInt8MultiArray", "/robot_a1/raw", "reliable"});
    publish_until(*robot, *seen, "robots/a1/raw", "?", "got /robot_a1/raw");
    seen->process().signal(SIGSTOP);
    const auto raw = robot->register_topic("robots/a1/raw");
    ASSERT_TRUE(raw);
    const std::string large(1000, 'x');
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < 2000; ++i) {
        ASSERT_TRUE(
            robot->publish(*raw, large, i % 20 == 0 ? Qos::exactly_once : Qos::at_most_once));
    }
    EXPECT_TRUE(robot->ping());
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 15s);
    seen->process().signal(SIGCONT);
    EXPECT_TRUE(metrics_come_to_say(*net::parse_endpoint(metrics()), "romano_ros2_is_open", 1));
    publish(*robot, "robots/a1/raw", "!");
    seen->wait_for("got /robot_a1/raw [0 ] 0 [1 33 ]");
}

}  // namespace
}  // namespace romano::system::ros2_load_test
