// ROMANO messages become ROS 2 messages and back, with units and signs as both sides mean them.

#include "overlay/ros2/conversion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "romano/base/bytes.h"

namespace romano::ros2::conversion_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr double pi = std::numbers::pi;

Rule rule_of(const std::string& type, const std::string& settings = "") {
    return parse_rules("both a/+ /r_+/a " + type + ' ' + settings).value()[0];
}

message::MovementControl movement(message::MovementType type, std::uint32_t amount) {
    static std::array<std::uint8_t, 4> arguments;
    put_be16(arguments, 0, static_cast<std::uint16_t>(amount >> 16U));
    put_be16(arguments, 2, static_cast<std::uint16_t>(amount));
    return {type, arguments};
}

/// Sensor data: type 6, length, sensor type, value.
Payload sensor(std::uint16_t type, std::vector<std::int32_t> values) {
    Payload out{0x06, static_cast<std::uint8_t>(4 + 4 * values.size()), 0,
                static_cast<std::uint8_t>(type)};
    for (const std::int32_t value : values) {
        for (int shift = 24; shift >= 0; shift -= 8) {
            out.push_back(static_cast<std::uint8_t>(static_cast<std::uint32_t>(value) >> shift));
        }
    }
    return out;
}

const Payload battery_7400_mv{0x06, 6, 0, 4, 0x1C, 0xE8};

TEST(MovementToTwist, IsAVelocityWithAnEnd) {
    const Rule rule = rule_of("geometry_msgs/msg/Twist", "speed=0.25 turn=0.5");
    const auto front = motion_of(movement(message::MovementType::front, 1000), rule);
    ASSERT_TRUE(front);
    EXPECT_EQ(front->velocity.linear, (Vector3{0.25, 0, 0}));
    EXPECT_EQ(front->time, to_duration(4s));
    EXPECT_EQ(motion_of(movement(message::MovementType::back, 1), rule)->velocity.linear.x, -0.25);
    EXPECT_EQ(motion_of(movement(message::MovementType::left, 1), rule)->velocity.linear.y, 0.25);
    EXPECT_EQ(motion_of(movement(message::MovementType::right, 1), rule)->velocity.linear.y, -0.25);
    const auto turn = motion_of(movement(message::MovementType::rotate_right, 90'000), rule);
    EXPECT_EQ(turn->velocity.angular, (Vector3{0, 0, -0.5}));
    EXPECT_NEAR(std::chrono::duration<double>(turn->time).count(), pi / 2 / 0.5, 1e-6);
    EXPECT_FALSE(motion_of({message::MovementType::first_of_application, {}}, rule));
}

TEST(MovementToTwist, TheLongestMovementHasAnEndToo) {
    const Rule rule = rule_of("geometry_msgs/msg/Twist", "speed=0.001");
    const auto far = motion_of(movement(message::MovementType::front, 0xFFFFFFFF), rule);
    EXPECT_NEAR(std::chrono::duration<double>(far->time).count(), 4294967295.0, 1);
}

TEST(TwistToMovement, IsTheWayOfOneStep) {
    const Rule rule = rule_of("geometry_msgs/msg/Twist", "step-ms=500");
    const Twist ahead{.linear = {0.2, 0, 0}};
    EXPECT_THAT(to_romano(ahead, rule),
                ElementsAre(Payload{0x07, 8, 0, 0, 0, 0, 0, 100}));  // front 100 mm
    const Twist curve{.linear = {-0.2, 0, 0}, .angular = {0, 0, pi / 4}};
    EXPECT_THAT(to_romano(curve, rule),
                ElementsAre(Payload{0x07, 8, 0, 1, 0, 0, 0, 100},       // back 100 mm
                            Payload{0x07, 8, 0, 4, 0, 0, 0x57, 0xE4}))  // rotate left 22.5 deg
        << "straight first";
    EXPECT_THAT(to_romano(Twist{}, rule), ElementsAre(Payload{0x07, 8, 0, 0, 0, 0, 0, 0}))
        << "a stop is said";
}

TEST(TwistToMovement, WhatIsNoNumberOrTooMuchIsNothing) {
    const Rule rule = rule_of("geometry_msgs/msg/Twist");
    for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e12}) {
        EXPECT_THAT(to_romano(Twist{.linear = {bad, 0, 0}}, rule), IsEmpty()) << bad;
        EXPECT_THAT(to_romano(Twist{.angular = {0, 0, -bad}}, rule), IsEmpty()) << bad;
    }
}

TEST(LocationToOdometry, IsInMetresWithTheHeadingAsAQuaternionAndTheSpeedBesideIt) {
    const Rule rule = rule_of("nav_msgs/msg/Odometry", "frame=odom child=r_+/base_link");
    const auto ros = to_ros(sensor(2, {1500, -250, 90'000}), rule, "7", 1'700'000'000'123,
                            Twist{.linear = {0.1, 0, 0}});
    ASSERT_TRUE(ros);
    const auto& odometry = std::get<Odometry>(*ros);
    EXPECT_EQ(odometry.header.sec, 1'700'000'000);
    EXPECT_EQ(odometry.header.nanosec, 123'000'000u);
    EXPECT_EQ(odometry.header.frame_id, "odom");
    EXPECT_EQ(odometry.child_frame_id, "r_7/base_link");
    EXPECT_EQ(odometry.position, (Vector3{1.5, -0.25, 0}));
    EXPECT_NEAR(odometry.orientation.z, std::sin(pi / 4), 1e-12);
    EXPECT_NEAR(odometry.orientation.w, std::cos(pi / 4), 1e-12);
    EXPECT_EQ(odometry.twist.linear.x, 0.1);
}

TEST(OdometryToLocation, IsInMillimetresAndMillidegreesAfterTheSpeed) {
    const Rule rule = rule_of("nav_msgs/msg/Odometry");
    Odometry odometry{.position = {1.5, -0.25, 9}};
    odometry.orientation = {0, 0, -std::sin(pi / 8), std::cos(pi / 8)};
    odometry.twist = {.linear = {0.1, 0, 0}, .angular = {0, 0, pi / 180}};
    EXPECT_THAT(to_romano(odometry, rule),
                ElementsAre(sensor(3, {100, 1000}), sensor(2, {1500, -250, -45'000})));
    odometry.position.x = 3e6;  // km
    EXPECT_THAT(to_romano(odometry, rule), IsEmpty());
}

TEST(SpeedToTwist, IsAlongTheHeading) {
    const auto octets = sensor(3, {-200, 180'000});
    const auto twist = twist_of({message::SensorType::speed, Bytes{octets}.subspan(4)});
    ASSERT_TRUE(twist);
    EXPECT_EQ(twist->linear.x, -0.2);
    EXPECT_NEAR(twist->angular.z, pi, 1e-12);
}

TEST(BatteryToRos, IsInVoltsWithItsPartOfFullWhereThatIsKnown) {
    const auto known = to_ros(
        battery_7400_mv, rule_of("sensor_msgs/msg/BatteryState", "full=8.4 empty=6.4"), "7", 0, {});
    ASSERT_TRUE(known);
    EXPECT_FLOAT_EQ(std::get<BatteryState>(*known).voltage, 7.4f);
    EXPECT_FLOAT_EQ(std::get<BatteryState>(*known).percentage, 0.5f);
    const auto unknown =
        to_ros(battery_7400_mv, rule_of("sensor_msgs/msg/BatteryState"), "7", 0, {});
    EXPECT_TRUE(std::isnan(std::get<BatteryState>(*unknown).percentage));
    EXPECT_THAT(to_romano(*known, rule_of("sensor_msgs/msg/BatteryState")),
                ElementsAre(battery_7400_mv));
    EXPECT_THAT(to_romano(BatteryState{}, rule_of("sensor_msgs/msg/BatteryState")), IsEmpty());
}

TEST(ProximityToRange, HasTheSensorsLimitsFromTheRule) {
    const Rule rule =
        rule_of("sensor_msgs/msg/Range", "radiation=infrared fov=0.3 min=0.1 max=0.8 frame=ir");
    const auto ros = to_ros(sensor(1, {450}), rule, "7", 5'000, {});
    ASSERT_TRUE(ros);
    EXPECT_EQ(std::get<Range>(*ros), (Range{.header = {5, 0, "ir"},
                                            .radiation_type = Range::infrared,
                                            .field_of_view = 0.3f,
                                            .min_range = 0.1f,
                                            .max_range = 0.8f,
                                            .range = 0.45f}));
    EXPECT_THAT(to_romano(*ros, rule), ElementsAre(sensor(1, {450})));
    EXPECT_THAT(to_romano(Range{.range = -1}, rule), IsEmpty());
}

TEST(AnyPayload, GoesAsOctetsAndUtf8AsAString) {
    const Payload octets{0, 1, 0xFF};
    EXPECT_EQ(std::get<UInt8MultiArray>(
                  *to_ros(octets, rule_of("std_msgs/msg/UInt8MultiArray"), "7", 0, {}))
                  .data,
              octets);
    EXPECT_THAT(to_romano(UInt8MultiArray{octets}, rule_of("std_msgs/msg/UInt8MultiArray")),
                ElementsAre(octets));
    const Rule text = rule_of("std_msgs/msg/String");
    const auto said = [&](const std::string& what) {
        return to_ros(as_octets(what), text, "7", 0, {});
    };
    EXPECT_EQ(std::get<String>(*said("grüße \xF0\x9F\xA4\x96")).data, "grüße \xF0\x9F\xA4\x96");
    for (const std::string& bad : {std::string("a\0b", 3), std::string("\xFF"), std::string("\xC3"),
                                   std::string("\xC0\x80"), std::string("\xED\xA0\x80")}) {
        EXPECT_FALSE(said(bad));
    }
}

TEST(APayloadOfAnotherKind, IsNothingOfTheRules) {
    for (const char* type :
         {"nav_msgs/msg/Odometry", "sensor_msgs/msg/BatteryState", "sensor_msgs/msg/Range"}) {
        EXPECT_FALSE(to_ros(Payload{}, rule_of(type), "7", 0, {})) << type;
        EXPECT_FALSE(to_ros(sensor(5, {1, 2}), rule_of(type), "7", 0, {})) << type;
        EXPECT_FALSE(to_ros(sensor(2, {1, 2}), rule_of(type), "7", 0, {})) << "too short";
    }
}

}  // namespace
}  // namespace romano::ros2::conversion_test
