// Which topics are bridged to ROS 2, as what, and how they are called on either side. A rule is a
// line of a rules file:
//
//     DIRECTION ROMANO-TOPIC ROS-TOPIC TYPE [KEY=VALUE ...]
//     out       robots/+/telemetry  /robot_+/odom  nav_msgs/msg/Odometry  frame=odom
//
// Both topics have the same wildcard, or none: + is one level on the ROMANO side, and a name or the
// rest of one on the ROS side; # is the rest of the topic. README.md lists the keys. Lines that are
// empty or begin with # say nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "overlay/ros2/ros_types.h"
#include "romano/base/result.h"
#include "romano/base/time.h"
#include "romano/mqttsn/types.h"

namespace romano::ros2 {

struct Rule {
    std::size_t line = 0;  // of the rules file
    bool out = false;      // to ROS 2
    bool in = false;
    std::string romano;
    std::string ros;
    RosType type{};
    mqttsn::Qos qos = mqttsn::Qos::exactly_once;  // at most; 1 and 2 are reliable on DDS
    bool retained = false;                        // transient-local on DDS

    std::string node = {};         // the ROS 2 node whose endpoints these are
    std::string frame = {};        // header.frame_id
    std::string child_frame = {};  // Odometry

    double speed = 0.2;                             // m/s of a movement's velocity
    double turn = 1.0;                              // rad/s of a rotation's
    Duration step{std::chrono::milliseconds{200}};  // a velocity is driven for so long

    double full = 0;  // V; 0: not known
    double empty = 0;

    std::uint8_t radiation_type = 0;  // Range
    double field_of_view = 0.5;
    double min_range = 0.02;
    double max_range = 4.0;
};

inline constexpr const char* bridge_node = "romano_bridge";

/// The error names the line, what is wrong and what is allowed instead.
[[nodiscard]] Result<std::vector<Rule>, std::string> parse_rules(std::string_view text);

/// What stands for the wildcard of `pattern` in `topic`; empty without a wildcard. Nothing when the
/// topic does not fit.
[[nodiscard]] std::optional<std::string> wild_part(std::string_view pattern,
                                                   std::string_view topic);
/// `pattern` with its wildcard replaced.
[[nodiscard]] std::string filled(std::string_view pattern, std::string_view part);
[[nodiscard]] bool has_wildcard(std::string_view pattern);

}  // namespace romano::ros2
