// Rules files of the ROS 2 bridge: what a line says, what it may not say, and names on both sides.

#include "overlay/ros2/rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

namespace romano::ros2::rules_test {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

std::vector<Rule> rules_of(const std::string& text) {
    auto rules = parse_rules(text);
    EXPECT_TRUE(rules) << (rules ? "" : rules.error());
    return rules ? rules.value() : std::vector<Rule>{};
}

std::string wrong(const std::string& text) {
    const auto rules = parse_rules(text);
    EXPECT_FALSE(rules) << text;
    return rules ? "" : rules.error();
}

TEST(BridgeRules, AreLinesOfDirectionTopicsTypeAndSettings) {
    const auto rules = rules_of(
        "# a comment\n\n"
        "out  robots/+/pose  /robot_+/odom  nav_msgs/msg/Odometry  frame=odom child=+/base qos=1\n"
        "in\t+\t/robot_+/cmd_vel\tgeometry_msgs/msg/Twist step-ms=500 retained=yes\r\n"
        "both log/# /romano/log/# std_msgs/msg/String node=logger");
    ASSERT_THAT(rules, SizeIs(3));
    EXPECT_EQ(rules[0].line, 3u);
    EXPECT_TRUE(rules[0].out && !rules[0].in);
    EXPECT_EQ(rules[0].romano, "robots/+/pose");
    EXPECT_EQ(rules[0].ros, "/robot_+/odom");
    EXPECT_EQ(rules[0].type, RosType::odometry);
    EXPECT_EQ(rules[0].qos, mqttsn::Qos::at_least_once);
    EXPECT_EQ(rules[0].child_frame, "+/base");
    EXPECT_EQ(rules[0].node, "robot_+") << "a robot is a node of its own";
    EXPECT_TRUE(rules[1].in && !rules[1].out && rules[1].retained);
    EXPECT_EQ(rules[1].qos, mqttsn::Qos::exactly_once) << "unless said otherwise";
    EXPECT_EQ(rules[1].step, to_duration(std::chrono::milliseconds{500}));
    EXPECT_TRUE(rules[2].in && rules[2].out);
    EXPECT_EQ(rules[2].node, "logger");
}

TEST(BridgeRules, ThatAreNotPossibleAreRefusedWithTheirLineAndWhatIsAllowed) {
    EXPECT_THAT(wrong("\nout a /a sensor_msgs/msg/Imu"),
                HasSubstr("line 2: 'sensor_msgs/msg/Imu' is no type that is bridged; write "
                          "geometry_msgs/msg/Twist, "));
    EXPECT_THAT(wrong("up a /a std_msgs/msg/String"), HasSubstr("'up' is no direction"));
    EXPECT_THAT(wrong("out a /a"), HasSubstr("write DIRECTION"));
    EXPECT_THAT(wrong("out a+ /a std_msgs/msg/String"), HasSubstr("'a+' is no ROMANO topic"));
    EXPECT_THAT(wrong("out $SYS/x /a std_msgs/msg/String"), HasSubstr("$"));
    EXPECT_THAT(wrong("out a a std_msgs/msg/String"), HasSubstr("'a' is no ROS 2 topic"));
    EXPECT_THAT(wrong("out a /1a std_msgs/msg/String"), HasSubstr("'/1a'"));
    EXPECT_THAT(wrong("out a /a__b std_msgs/msg/String"), HasSubstr("'/a__b'"));
    EXPECT_THAT(wrong("out a/# /a# std_msgs/msg/String"), HasSubstr("'/a#'"));
    EXPECT_THAT(wrong("out a/+ /a std_msgs/msg/String"), HasSubstr("same wildcard"));
    EXPECT_THAT(wrong("out a/+/+ /a/+ std_msgs/msg/String"), HasSubstr("same wildcard"));
    EXPECT_THAT(wrong("out a/+ /a/# std_msgs/msg/String"), HasSubstr("same wildcard"));
    EXPECT_THAT(wrong("out a /a std_msgs/msg/String qos=3"),
                HasSubstr("qos '3' must be 0, 1 or 2"));
    EXPECT_THAT(wrong("out a /a std_msgs/msg/String frame=x"),
                HasSubstr("'frame=x' is no setting of std_msgs/msg/String; write KEY=VALUE with "
                          "one of qos, retained, node"));
    EXPECT_THAT(wrong("out a /a geometry_msgs/msg/Twist speed=0"), HasSubstr("0.001 to 100 m/s"));
    EXPECT_THAT(wrong("out a /a geometry_msgs/msg/Twist speed=nan"), HasSubstr("'nan'"));
    EXPECT_THAT(wrong("out a /a sensor_msgs/msg/BatteryState full=8"), HasSubstr("full and empty"));
    EXPECT_THAT(wrong("out a /a std_msgs/msg/String node=robot_+"), HasSubstr("no +"));
    EXPECT_THAT(wrong("# nothing\n"), HasSubstr("no rule"));
}

TEST(BridgeRules, OfTheExamplesArePossible) {
    for (const char* name : {"romano-robots.rules", "turtlebots.rules"}) {
        std::ifstream file(std::string(ROMANO_SOURCE_DIR "/overlay/ros2/examples/") + name);
        const std::string text{std::istreambuf_iterator<char>(file), {}};
        EXPECT_THAT(rules_of(text), testing::Not(testing::IsEmpty())) << name;
    }
}

TEST(BridgeRules, GiveATopicOfRos2OneType) {
    EXPECT_THAT(wrong("out a /a std_msgs/msg/String\nout b /a sensor_msgs/msg/Range"),
                HasSubstr("line 2: '/a' is sensor_msgs/msg/Range here"));
    EXPECT_THAT(wrong("out a/+ /r_+/x std_msgs/msg/String\nout b /r_1/x sensor_msgs/msg/Range"),
                HasSubstr("in line 1"));
    EXPECT_THAT(rules_of("out a /a std_msgs/msg/String\nin b /a std_msgs/msg/String"), SizeIs(2));
}

TEST(BridgeRules, CarryWhatStandsForTheWildcardToTheOtherSide) {
    EXPECT_EQ(wild_part("robots/+/pose", "robots/abcd1234/pose"), "abcd1234");
    EXPECT_EQ(wild_part("/robot_+/odom", "/robot_abcd1234/odom"), "abcd1234");
    EXPECT_EQ(wild_part("robots/+/pose", "robots/a/b/pose"), std::nullopt);
    EXPECT_EQ(wild_part("robots/+/pose", "robots//pose"), std::nullopt);
    EXPECT_EQ(wild_part("log/#", "log/a/b"), "a/b");
    EXPECT_EQ(wild_part("log/#", "log"), std::nullopt);
    EXPECT_EQ(wild_part("log", "log"), "");
    EXPECT_EQ(filled("/robot_+/odom", "7"), "/robot_7/odom");
}

TEST(RosNames, OfTopicsAndTypesAreThoseOfRos2OnDds) {
    EXPECT_EQ(dds_topic_name("/robot/odom"), "rt/robot/odom");
    EXPECT_EQ(ros_topic_name("rt/robot/odom"), "/robot/odom");
    EXPECT_EQ(ros_topic_name("rq/service/x"), "");
    EXPECT_EQ(ros_topic_name("ros_discovery_info"), "");
    EXPECT_EQ(dds_type_name(RosType::uint8_multi_array), "std_msgs::msg::dds_::UInt8MultiArray_");
    EXPECT_EQ(ros_type_name("std_msgs::msg::dds_::UInt8MultiArray_"),
              "std_msgs/msg/UInt8MultiArray");
    EXPECT_EQ(ros_type_name("romano_wire::Sample"), "");
    EXPECT_TRUE(is_ros_topic("/a_1/b"));
    for (const char* name : {"", "/", "a", "/a/", "//a", "/a b", "/a/2", "/a__b", "/ä"}) {
        EXPECT_FALSE(is_ros_topic(name)) << name;
    }
}

TEST(RosNames, TypeHashesAreToldFromIronOn) {
    EXPECT_EQ(endpoint_user_data(RosType::string, Release::iron),
              "typehash=RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18;"
              "romano=bridge;");
    EXPECT_EQ(endpoint_user_data(RosType::string, Release::humble), "romano=bridge;");
    EXPECT_TRUE(is_of_a_bridge(endpoint_user_data(RosType::twist, Release::iron)));
    EXPECT_FALSE(is_of_a_bridge("typehash=RIHS01_00;"));
}

}  // namespace
}  // namespace romano::ros2::rules_test
