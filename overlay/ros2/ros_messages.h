// The ROS 2 messages that are bridged, as values: fields, units and frames as in their .msg files
// (metres, radians, seconds, volts; REP 103: x ahead, y left, z up). What ROMANO knows nothing of,
// such as covariances, is left out here.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace romano::ros2 {

inline constexpr float not_measured = std::numeric_limits<float>::quiet_NaN();

struct Vector3 {
    double x = 0;
    double y = 0;
    double z = 0;

    friend bool operator==(const Vector3&, const Vector3&) = default;
};

struct Quaternion {
    double x = 0;
    double y = 0;
    double z = 0;
    double w = 1;

    friend bool operator==(const Quaternion&, const Quaternion&) = default;
};

struct Header {
    std::int32_t sec = 0;  // since the Unix epoch
    std::uint32_t nanosec = 0;
    std::string frame_id = {};

    friend bool operator==(const Header&, const Header&) = default;
};

struct Twist {  // metres and radians a second
    Vector3 linear = {};
    Vector3 angular = {};

    friend bool operator==(const Twist&, const Twist&) = default;
};

struct Odometry {  // covariances: zero, which says "not known"
    Header header = {};
    std::string child_frame_id = {};
    Vector3 position = {};
    Quaternion orientation = {};
    Twist twist = {};

    friend bool operator==(const Odometry&, const Odometry&) = default;
};

struct BatteryState {  // of its other fields: not a number, or "unknown"
    Header header = {};
    float voltage = not_measured;
    float percentage = not_measured;  // 0 to 1
};

struct Range {
    static constexpr std::uint8_t ultrasound = 0;
    static constexpr std::uint8_t infrared = 1;

    Header header = {};
    std::uint8_t radiation_type = ultrasound;
    float field_of_view = 0;
    float min_range = 0;
    float max_range = 0;
    float range = 0;

    friend bool operator==(const Range&, const Range&) = default;
};

struct String {
    std::string data = {};

    friend bool operator==(const String&, const String&) = default;
};

struct UInt8MultiArray {  // its layout: no dimensions
    std::vector<std::uint8_t> data = {};

    friend bool operator==(const UInt8MultiArray&, const UInt8MultiArray&) = default;
};

/// In the order of RosType.
using RosMessage = std::variant<Twist, Odometry, BatteryState, Range, String, UInt8MultiArray>;

}  // namespace romano::ros2
