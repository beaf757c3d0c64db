// What ROS 2 calls its topics and types on DDS, for the releases that differ there.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace romano::ros2 {

/// In the order of RosMessage.
enum class RosType : std::uint8_t {
    twist,
    odometry,
    battery_state,
    range,
    string,
    uint8_multi_array,
};
inline constexpr std::size_t ros_types = 6;

/// Iron and Jazzy speak alike; Humble has longer gids, a shorter Range and no type hashes.
enum class Release : std::uint8_t { humble, iron };

[[nodiscard]] std::string_view name_of(RosType type);  // "geometry_msgs/msg/Twist"
[[nodiscard]] std::optional<RosType> type_named(std::string_view name);
/// All names, for people: "a, b or c".
[[nodiscard]] std::string names_of_types();

/// "geometry_msgs::msg::dds_::Twist_"
[[nodiscard]] std::string dds_type_name(RosType type);
/// The way back, for types of any name; empty when it is no name of ROS 2.
[[nodiscard]] std::string ros_type_name(std::string_view dds_type);

/// "/robot/odom" is DDS topic "rt/robot/odom".
[[nodiscard]] std::string dds_topic_name(std::string_view topic);
/// Empty when no ROS 2 topic has that DDS topic.
[[nodiscard]] std::string ros_topic_name(std::string_view dds_topic);

/// A topic's name with its namespace: "/" and levels of letters, digits and single underscores that
/// begin with no digit (ROS 2 design, "Topic and Service name mapping to DDS").
[[nodiscard]] bool is_ros_topic(std::string_view name);
/// One such level.
[[nodiscard]] bool is_ros_name(std::string_view name);

/// User data of our endpoints. Its mark tells bridges what a bridge wrote: none takes that in.
[[nodiscard]] std::string endpoint_user_data(RosType type, Release release);
[[nodiscard]] bool is_of_a_bridge(std::string_view user_data);

}  // namespace romano::ros2
