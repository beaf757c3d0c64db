// The bridge to ROS 2 against Fast DDS, and for a second reader an RTPS stack of npm: each type
// octet by octet both ways, nodes, latched topics, movements, the death of the leader, types and
// settings that do not fit.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>

#include "romano/keys/key_folder.h"
#include "tests/system/metrics_page.h"
#include "tests/system/ros2_fixture.h"

namespace romano::system::ros2_test {
namespace {

using namespace ros2;
using testing::ContainsRegex;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;

TEST_F(Ros2, FastDdsReadsEachTypeAsItWritesItItself) {
    BrokerProcess& broker = start(1, robots);
    ASSERT_TRUE(wait_for_trace(broker, "ros2: bridged here")) << broker.errors();
    const auto robot = client("robot");
    publish(*robot, "robots/a1/telemetry", speed_100_mm_s);  // the robot is known from now on
    const auto seen = peer({"sub", "Odometry",        "/robot_a1/odom",    "reliable",
                            "sub", "BatteryState",    "/robot_a1/battery", "reliable",
                            "sub", "Range",           "/robot_a1/range",   "best-effort",
                            "sub", "UInt8MultiArray", "/robot_a1/raw",     "reliable",
                            "sub", "Twist",           "/robot_a1/cmd_vel", "reliable",
                            "sub", "String",          "/robot_a1/text",    "reliable"});
    seen->wait_for("subscribed /robot_a1/", 6);
    const auto say = [&](const std::string& topic, const std::string& data,
                         const std::string& heard) {
        publish_until(*robot, *seen, "robots/a1/" + topic, data, "got /robot_a1/" + heard);
    };
    say("telemetry", location, "odom");
    say("telemetry", battery_7500_mv, "battery");
    say("telemetry", proximity_450_mm, "range");
    say("raw", octets({0, 1, 255}), "raw");
    say("move", movement(4, 1), "cmd_vel 0 0 0 0 0 1");  // to the left
    say("text", "hello", "text");

    EXPECT_THAT(seen->wait_for("got /robot_a1/odom ")[0],
                ContainsRegex("^got /robot_a1/odom [0-9]+ [0-9]+ odom a1 1 -0.5 0 0 0 0.707107 "
                              "0.707107( 0){36} 0.1 0 0 0 0 0( 0){36}$"));
    EXPECT_THAT(seen->wait_for("got /robot_a1/battery ")[0],
                ContainsRegex("battery [0-9]+ [0-9]+  7.5 nan nan nan nan nan 0.5 0 0 0 1 \\[0 \\] "
                              "\\[0 \\]  $"));
    EXPECT_THAT(seen->wait_for("got /robot_a1/range ")[0],
                ContainsRegex("range [0-9]+ [0-9]+  0 0.5 0.25 4 0.45 0$"));
    EXPECT_EQ(seen->wait_for("got /robot_a1/raw ")[0], "got /robot_a1/raw [0 ] 0 [3 0 1 255 ]");
    EXPECT_EQ(seen->wait_for("got /robot_a1/text ")[0], "got /robot_a1/text hello");
    const Lines compared = seen->seen("bytes ");
    EXPECT_GE(compared.size(), 6u);
    for (const std::string& line : compared) EXPECT_THAT(line, testing::EndsWith(" same"));

    const auto now = std::chrono::duration_cast<std::chrono::seconds>(
                         std::chrono::system_clock::now().time_since_epoch())
                         .count();
    std::istringstream odometry(seen->seen("got /robot_a1/odom ")[0].substr(19));
    long long stamp = 0;
    odometry >> stamp;
    EXPECT_NEAR(static_cast<double>(stamp), static_cast<double>(now), 60) << "its time stamp";
}

#ifdef ROS2_READER
TEST_F(Ros2, AnRtpsStackOfNpmReadsEachTypeToo) {
    BrokerProcess& broker = start(1, R"(
out robots/+/telemetry /robot_+/odom     nav_msgs/msg/Odometry       frame=odom child=+ retained=yes
out robots/+/telemetry /robot_+/battery  sensor_msgs/msg/BatteryState full=8.5 empty=6.5 retained=yes
out robots/+/telemetry /robot_+/range    sensor_msgs/msg/Range min=0.25 max=4 fov=0.5 retained=yes
out robots/+/raw       /robot_+/raw      std_msgs/msg/UInt8MultiArray retained=yes
out robots/+/move      /robot_+/cmd_vel  geometry_msgs/msg/Twist retained=yes
out robots/+/text      /robot_+/text     std_msgs/msg/String retained=yes
)");
    ASSERT_TRUE(wait_for_trace(broker, "ros2: bridged here")) << broker.errors();
    const auto robot = client("robot");
    for (const std::string& data : {speed_100_mm_s, location, battery_7500_mv, proximity_450_mm}) {
        publish(*robot, "robots/a1/telemetry", data);
    }
    publish(*robot, "robots/a1/raw", octets({0, 1, 255}));
    publish(*robot, "robots/a1/move", movement(0, 60'000));
    publish(*robot, "robots/a1/text", "hello");
    ::setenv("ROS2_TEST_MODULES", ROS2_TEST_MODULES, 1);
    RosPeer seen(
        NODE_PROGRAM,
        {ROS2_READER, std::to_string(ros.id()), "/robot_a1/odom=nav_msgs/msg/Odometry",
         "/robot_a1/battery=sensor_msgs/msg/BatteryState", "/robot_a1/range=sensor_msgs/msg/Range",
         "/robot_a1/raw=std_msgs/msg/UInt8MultiArray", "/robot_a1/cmd_vel=geometry_msgs/msg/Twist",
         "/robot_a1/text=std_msgs/msg/String"});
    const std::string odometry = seen.wait_for("read /robot_a1/odom")[0];
    for (const char* part :
         {R"("frame_id":"odom"},"child_frame_id":"a1")", R"("position":{"x":1,"y":-0.5,"z":0})",
          R"("orientation":{"x":0,"y":0,"z":0.70710678)", R"("linear":{"x":0.1,"y":0,"z":0})"}) {
        EXPECT_THAT(odometry, HasSubstr(part));
    }
    const std::string battery = seen.wait_for("read /robot_a1/battery")[0];
    for (const char* part : {R"("voltage":7.5)", R"("percentage":0.5)", R"("present":true)"}) {
        EXPECT_THAT(battery, HasSubstr(part));
    }
    EXPECT_THAT(seen.wait_for("read /robot_a1/range")[0],
                HasSubstr(R"("field_of_view":0.5,"min_range":0.25,"max_range":4,"range":0.4)"));
    EXPECT_THAT(seen.wait_for("read /robot_a1/raw")[0], HasSubstr(R"("data":[0,1,255])"));
    EXPECT_THAT(seen.wait_for("read /robot_a1/cmd_vel")[0],
                HasSubstr(R"("linear":{"x":0.2,"y":0,"z":0},"angular":{"x":0,"y":0,"z":0})"));
    EXPECT_THAT(seen.wait_for("read /robot_a1/text")[0], HasSubstr(R"({"data":"hello"})"));
}
#endif

TEST_F(Ros2, RobotsAreNodesWithTypeHashes) {
    BrokerProcess& broker = start(1, robots);
    ASSERT_TRUE(wait_for_trace(broker, "ros2: bridged here")) << broker.errors();
    const auto seen = peer({});
    const auto robot = client("robot");
    publish(*robot, "robots/a1/text", "hi");
    publish(*robot, "robots/b2/text", "hi");
    seen->wait_for("nodes /robot_a1/0/6 /robot_b2/0/6");
    EXPECT_THAT(seen->wait_for("writer rt/robot_a1/odom")[0],
                HasSubstr("nav_msgs::msg::dds_::Odometry_ typehash=RIHS01_3cc97dc7"));
    broker.signal(SIGTERM);
    EXPECT_EQ(broker.wait_for_exit(), 0);
    seen->wait_for("nodes none");  // they leave with it
}

TEST_F(Ros2, HumbleHasItsOwnRangeAndGids) {
    BrokerProcess& broker = start(1, robots, {"--ros2-release", "humble"});
    ASSERT_TRUE(wait_for_trace(broker, "ros2: bridged here")) << broker.errors();
    const auto robot = client("robot");
    publish(*robot, "robots/a1/text", "hi");
    const auto seen = peer({"sub", "Range", "/robot_a1/range", "reliable"}, "humble");
    publish_until(*robot, *seen, "robots/a1/telemetry", proximity_450_mm, "got /robot_a1/range");
    EXPECT_THAT(seen->wait_for("got /robot_a1/range ")[0], testing::EndsWith(" 0 0.5 0.25 4 0.45"));
    EXPECT_THAT(seen->wait_for("bytes ")[0], testing::EndsWith(" same"));
    seen->wait_for("nodes /robot_a1/0/6");
    EXPECT_THAT(seen->seen("writer rt/robot_a1/range")[0], Not(HasSubstr("typehash")));
}

TEST_F(Ros2, TakesInEachTypeThatFastDdsWrites) {
    BrokerProcess& broker = start(1, R"(
in robots/+/move    /robot_+/cmd_vel  geometry_msgs/msg/Twist       step-ms=500
in robots/+/place   /robot_+/odom     nav_msgs/msg/Odometry
in robots/+/battery /robot_+/battery  sensor_msgs/msg/BatteryState
in robots/+/range   /robot_+/range    sensor_msgs/msg/Range          qos=0
in robots/+/raw     /robot_+/raw      std_msgs/msg/UInt8MultiArray   qos=1
in robots/+/text    /robot_+/text     std_msgs/msg/String            retained=yes
)");
    ASSERT_TRUE(wait_for_trace(broker, "ros2: bridged here")) << broker.errors();
    const auto robot = client("robot");
    ASSERT_TRUE(robot->subscribe("robots/#", Qos::exactly_once));
    const std::string zeros = [] {
        std::string out;
        for (int i = 0; i < 36; ++i) out += " 0";
        return out;
    }();
    // What a volatile publisher says in the moment of its discovery may be lost, as in ROS 2.
    const auto often = [](const std::string& type, const std::string& topic, const std::string& qos,
                          const std::string& fields) {
        return Lines{"pub", type, "/robot_a1/" + topic, qos, "20", "100", fields};
    };
    Lines wanted;
    for (const Lines& one :
         {often("Twist", "cmd_vel", "reliable", "0.2 0 0 0 0 0"),
          often("Odometry", "odom", "reliable",
                "7 8 odom base 1 -0.5 0 0 0 0.70710678 0.70710678" + zeros + " 0.1 0 0 0 0 0"),
          often("BatteryState", "battery", "reliable", "7 8 x 7.5"),
          often("Range", "range", "best-effort", "7 8 x 0 0.5 0.25 4 0.45"),
          often("UInt8MultiArray", "raw", "reliable", "0 0 3 0 1 255"),
          Lines{"pub", "String", "/robot_a1/text", "latched", "1", "1", "hello"}}) {
        wanted.insert(wanted.end(), one.begin(), one.end());
    }
    const auto seen = peer(wanted);
    const auto got = [&](const std::string& topic) {
        Lines data;
        for (const auto& message : robot->received) {
            if (message.topic == "robots/a1/" + topic) data.push_back(message.data);
        }
        return data;
    };
    ASSERT_TRUE(robot->run_until([&] {
        return !got("move").empty() && got("place").size() >= 2 && !got("battery").empty() &&
               !got("range").empty() && !got("raw").empty() && !got("text").empty();
    }));
    EXPECT_THAT(got("move"), Each(movement(0, 100)));
    EXPECT_EQ(got("place").at(0), speed_100_mm_s);
    EXPECT_EQ(got("place").at(1), location);
    EXPECT_THAT(got("battery"), Each(battery_7500_mv));
    EXPECT_THAT(got("range"), Each(proximity_450_mm));
    EXPECT_THAT(got("raw"), Each(octets({0, 1, 255})));
    EXPECT_THAT(got("text"), ElementsAre("hello"));
    seen->wait_for("nodes /robot_a1/6/0");

    const auto late = client("late");
    ASSERT_TRUE(late->subscribe("robots/a1/text", Qos::exactly_once));
    EXPECT_TRUE(late->run_until([&] { return !late->received.empty(); }));
    EXPECT_TRUE(late->received[0].retain) << "transient-local there is retained here";
}

TEST_F(Ros2, RetainedHereIsTransientLocalThere) {
    BrokerProcess& broker = start(1, "out site /site std_msgs/msg/String retained=yes");
    ASSERT_TRUE(wait_for_trace(broker, "ros2: bridged here")) << broker.errors();
    const auto robot = client("robot");
    publish(*robot, "site", "old", Qos::at_least_once, true);
    publish(*robot, "site", "new", Qos::at_least_once, true);
    EXPECT_EQ(peer({"sub", "String", "/site", "latched"})->wait_for("got /site")[0],
              "got /site new");
}

TEST_F(Ros2, LateSubscriptionsGetWhatIsRetainedFromTheNextLeaderToo) {
    const std::string rules = "out site /site std_msgs/msg/String retained=yes";
    BrokerProcess& next = start(1, rules);
    BrokerProcess& leader = start(2, rules);
    ASSERT_TRUE(wait_for_trace(leader, "ros2: bridged here")) << leader.errors();
    publish(*client("robot"), "site", "kept", Qos::exactly_once, true);
    EXPECT_EQ(peer({"sub", "String", "/site", "latched"})->wait_for("got /site")[0],
              "got /site kept");
    leader.kill_9();
    ASSERT_TRUE(wait_for_trace(next, "ros2: bridged here")) << next.errors();
    EXPECT_EQ(peer({"sub", "String", "/site", "latched"})->wait_for("got /site")[0],
              "got /site kept");
}

TEST_F(Ros2, AMovementIsAVelocityUntilItsEnd) {
    BrokerProcess& broker = start(1, robots);
    ASSERT_TRUE(wait_for_trace(broker, "ros2: bridged here")) << broker.errors();
    const auto robot = client("robot");
    publish(*robot, "robots/a1/text", "hi");
    const auto seen = peer({"sub", "Twist", "/robot_a1/cmd_vel", "reliable"});
    const std::string back = "got /robot_a1/cmd_vel -0.25 0 0 0 0 0";
    const std::string stop = "got /robot_a1/cmd_vel 0 0 0 0 0 0";
    publish_until(*robot, *seen, "robots/a1/move", movement(0, 0), stop);
    publish(*robot, "robots/a1/move", movement(1, 100));  // 0.4 s
    const auto twists = [&] { return seen->seen("got /robot_a1/cmd_vel"); };
    EXPECT_TRUE(seen->read_until([&] {
        const Lines all = twists();
        return std::ranges::count(all, back) > 0 && all.back() == stop;
    }));
    Lines driven = twists();
    driven.erase(driven.begin(), std::ranges::find(driven, back));
    EXPECT_GE(driven.size(), 4u) << "repeated meanwhile";
    EXPECT_EQ(std::ranges::count(driven, back), static_cast<int>(driven.size()) - 1);

    publish(*robot, "robots/a1/move", movement(0, 60'000));
    seen->wait_for("got /robot_a1/cmd_vel 0.25 0 0 0 0 0");
    const std::size_t stops = seen->seen(stop).size();
    broker.signal(SIGTERM);
    seen->wait_for(stop, stops + 1);  // nobody drives on for a broker that has left
}

TEST_F(Ros2, NothingComesBackToWhereItCameFrom) {
    BrokerProcess& broker = start(1, "both say /say std_msgs/msg/String");
    ASSERT_TRUE(wait_for_trace(broker, "ros2: bridged here")) << broker.errors();
    const auto robot = client("robot");
    ASSERT_TRUE(robot->subscribe("say", Qos::exactly_once));
    const auto seen = peer({"sub", "String", "/say", "reliable", "pub", "String", "/say",
                            "reliable", "1000", "50", "there%"});
    seen->wait_for("subscribed /say", 2);  // to the broker's, and to its own
    const auto heard = [&](const std::string& words) {
        std::map<std::string, int> times;
        for (const auto& message : robot->received) {
            if (message.data.starts_with(words)) ++times[message.data];
        }
        return times;
    };
    ASSERT_TRUE(robot->run_until([&] { return heard("there").size() >= 3; }));
    for (int i = 1; i <= 10; ++i) {
        publish(*robot, "say", "here" + std::to_string(i), Qos::exactly_once);
    }
    seen->wait_for("got /say here10");
    ASSERT_TRUE(robot->run_until([&] { return heard("here").size() >= 10; }));
    // What comes now comes after whatever would have come back.
    const std::size_t until_now = heard("there").size();
    ASSERT_TRUE(robot->run_until([&] { return heard("there").size() >= until_now + 3; }));
    EXPECT_THAT(heard("here"), SizeIs(10));
    for (const auto& [data, times] : heard("")) EXPECT_EQ(times, 1) << data;
    std::map<std::string, int> there;
    for (const std::string& line : seen->seen("got /say ")) ++there[line];
    for (const auto& [line, times] : there) EXPECT_EQ(times, 1) << line;
}

/// It is named, and who writes what the rule says is heard beside it.
TEST_F(Ros2, APublisherOfAnotherTypeThanTheRulesIsNamedAndDisturbsNobody) {
    BrokerProcess& broker = start(1, R"(
in robots/+/move    /robot_+/cmd_vel  geometry_msgs/msg/Twist       step-ms=500
out robots/+/telemetry /robot_+/odom  nav_msgs/msg/Odometry
)",
                                  {"--metrics", metrics()});
    ASSERT_TRUE(wait_for_trace(broker, "ros2: bridged here")) << broker.errors();
    const auto robot = client("robot");
    ASSERT_TRUE(robot->subscribe("robots/+/move", Qos::exactly_once));
    const auto wrong = peer({"pub", "String", "/robot_a1/cmd_vel", "reliable", "1", "1", "go"});
    EXPECT_TRUE(
        wait_for_trace(broker, "std_msgs/msg/String there and geometry_msgs/msg/Twist here"))
        << broker.errors();
    const auto right =
        peer({"pub", "Twist", "/robot_a1/cmd_vel", "reliable", "100", "100", "0.2 0 0 0 0 0"});
    EXPECT_TRUE(robot->run_until([&] { return !robot->received.empty(); }));
    for (const auto& message : robot->received) EXPECT_EQ(message.data, movement(0, 100));

    // The other way: octets that are no location.
    publish(*robot, "robots/a1/telemetry", "this is no telemetry");
    EXPECT_TRUE(metrics_come_to_say(*net::parse_endpoint(metrics()),
                                    "romano_ros2_drops_total{reason=\"unfit\"}", 1));
}

/// Three brokers, of which the third leads. Those that prove themselves to each other are in two
/// DDS domains each: their own, which DDS Security protects, and ROS 2's, which is plain.
struct NextLeader : Ros2, testing::WithParamInterface<bool> {
    void start_all(const std::string& rules) {
        keys::KeyFolder fleet(folder / "fleet");
        fleet.add({.brokers = {"r1", "r2", "r3"}, .robots = {}, .operators = {}});
        for (const int n : {1, 2, 3}) {
            const std::string own = fleet.broker_folder("r" + std::to_string(n));
            start(n, rules, GetParam() ? Lines{"--keys", own} : Lines{});
        }
        ASSERT_TRUE(wait_for_trace(*brokers[2], "ros2: bridged here")) << brokers[2]->errors();
    }
    [[nodiscard]] BrokerProcess& leader() { return *brokers[2]; }
    [[nodiscard]] BrokerProcess& next() { return *brokers[1]; }
};
INSTANTIATE_TEST_SUITE_P(Brokers, NextLeader, testing::Bool(), [](const auto& test) {
    return test.param ? "ThatProveThemselves" : "Plain";
});

/// Numbered messages both ways while the leader is killed.
TEST_P(NextLeader, GoesOnAndDoublesNothing) {
    ASSERT_NO_FATAL_FAILURE(
        start_all(std::string(robots) + "in robots/+/say /robot_+/say std_msgs/msg/String\n"));
    const auto robot = client("robot");
    ASSERT_TRUE(robot->subscribe("robots/a1/say", Qos::exactly_once));
    publish(*robot, "robots/a1/text", "hi");
    publish(*robot, "robots/a1/move", movement(0, 60'000));  // for four minutes
    const auto seen =
        peer({"sub", "Odometry", "/robot_a1/odom", "reliable", "sub", "String", "/robot_a1/text",
              "reliable", "sub", "Twist", "/robot_a1/cmd_vel", "reliable", "pub", "String",
              "/robot_a1/say", "reliable", "300", "20", "%"});
    seen->wait_for("subscribed /robot_a1/", 3);
    publish_until(*robot, *seen, "robots/a1/text", "ready", "got /robot_a1/text ready");
    ASSERT_TRUE(robot->run_until([&] { return !robot->received.empty(); }));
    const auto text = robot->register_topic("robots/a1/text");
    const auto telemetry = robot->register_topic("robots/a1/telemetry");
    ASSERT_TRUE(text && telemetry);
    constexpr int messages = 80;
    for (int i = 1; i <= messages; ++i) {
        if (i == messages / 3) leader().kill_9();
        ASSERT_TRUE(robot->publish(*telemetry, location, Qos::at_most_once));
        ASSERT_TRUE(robot->publish(*text, std::to_string(i), Qos::exactly_once));
        robot->run_until([] { return false; }, 20ms);
    }
    EXPECT_TRUE(wait_for_trace(next(), "ros2: bridged here")) << next().errors();
    seen->wait_for("got /robot_a1/text " + std::to_string(messages));
    int arrived = 0;
    for (int i = 1; i <= messages; ++i) {
        const std::string line = "got /robot_a1/text " + std::to_string(i);
        const auto times = std::ranges::count(seen->seen("got /robot_a1/text"), line);
        EXPECT_LE(times, 1) << i;
        if (times == 1) ++arrived;
    }
    EXPECT_GE(arrived, messages - 10) << "but for what was just leaving the dead leader";
    EXPECT_GE(seen->seen("got /robot_a1/odom").size(), 50u);
    seen->wait_for("got /robot_a1/cmd_vel 0 0 0 0 0 0");  // nobody drives on for a dead leader

    EXPECT_TRUE(robot->run_until([&] { return robot->received.back().data == "300"; }));
    std::map<std::string, int> times;
    for (const auto& message : robot->received) ++times[message.data];
    for (const auto& [number, count] : times) EXPECT_EQ(count, 1) << number;
    EXPECT_GE(times.size(), 50u) << "what ROS 2 says while nobody leads is lost";
    std::cout << "of 300 from ROS 2 came " << times.size() << ", of " << messages << " to it "
              << arrived << std::endl;
}

/// Its longest gap is what a robot's navigation sees of the leader's death; it is printed.
TEST_P(NextLeader, LetsOdometryAt50HzFlowOn) {
    ASSERT_NO_FATAL_FAILURE(start_all(robots));
    const auto robot = client("robot");
    const auto telemetry = robot->register_topic("robots/a1/telemetry");
    ASSERT_TRUE(telemetry);
    ASSERT_TRUE(robot->publish(*telemetry, location, Qos::at_most_once));
    const auto seen = peer({"sub", "Odometry", "/robot_a1/odom", "reliable"});
    publish_until(*robot, *seen, "robots/a1/telemetry", location, "got /robot_a1/odom");
    for (int i = 0; i < 200; ++i) {
        if (i == 100) leader().kill_9();
        ASSERT_TRUE(robot->publish(*telemetry, location, Qos::at_most_once));
        robot->run_until([] { return false; }, 20ms);
    }
    long long longest = 0;
    long long last = 0;
    for (const std::string& line : seen->wait_for("at /robot_a1/odom", 150)) {
        const long long at = std::stoll(line.substr(line.rfind(' ')));
        if (last != 0) longest = std::max(longest, at - last);
        last = at;
    }
    std::cout << "longest gap of Odometry: " << longest << " ms" << std::endl;
    EXPECT_LT(longest, 5'000);
}

TEST(Ros2Settings, ThatAreNotPossibleAreOneSentence) {
    const tests::TemporaryFolder folder;
    const auto rules = [&](const std::string& text) {
        std::ofstream(folder / "rules") << text;
        return (folder / "rules").string();
    };
    const auto refusal = [](Lines arguments) {
        arguments.insert(arguments.end(), {"--listen", "127.77.0.1:0"});
        BrokerProcess broker(arguments);
        EXPECT_EQ(broker.wait_for_exit(), 2);
        EXPECT_EQ(std::ranges::count(broker.errors(), '\n'), 1) << broker.errors();
        return broker.errors();
    };
    const auto with = [&](const Lines& more) {
        Lines all{"--domain", "7", "--interface", "lo", "--ros2-domain", "8"};
        all.insert(all.end(), more.begin(), more.end());
        return refusal(all);
    };
    EXPECT_THAT(refusal({"--ros2-domain", "8"}), HasSubstr("--domain too"));
    EXPECT_THAT(refusal({"--domain", "7", "--ros2-domain", "7"}), HasSubstr("'7'"));
    EXPECT_THAT(refusal({"--domain", "7", "--ros2-domain", "231"}), HasSubstr("'231'"));
    EXPECT_THAT(refusal({"--ros2-rules", "x"}), HasSubstr("--ros2-rules needs --ros2-domain"));
    EXPECT_THAT(with({}), HasSubstr("--ros2-rules"));
    EXPECT_THAT(with({"--ros2-rules", "/no/such"}), HasSubstr("'/no/such'"));
    EXPECT_THAT(
        with({"--ros2-rules", rules("out a /a std_msgs/msg/String"), "--ros2-release", "foxy"}),
        HasSubstr("'foxy'"));
    EXPECT_THAT(with({"--ros2-rules", rules("out a /a sensor_msgs/msg/Imu")}),
                HasSubstr("line 1: 'sensor_msgs/msg/Imu' is no type that is bridged"));
    EXPECT_THAT(
        with({"--ros2-rules", rules("out a /a std_msgs/msg/String"), "--ros2-interface", "none0"}),
        HasSubstr("none0"));
    EXPECT_THAT(with({"--ros2-rules", rules("out a /a std_msgs/msg/String"), "--uplink", "mqtt://h",
                      "--uplink-network", "x", "--uplink-topic", "a"}),
                HasSubstr("exclude each other"));
}

}  // namespace
}  // namespace romano::system::ros2_test
