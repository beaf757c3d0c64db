// What ROS 2 nodes are called here, and their endpoints on DDS.
#pragma once

#include <string>

namespace romano::bench::ros {

/// "/t" is DDS topic "rt/t" (ROS 2 design, "Topic and Service name mapping to DDS").
inline std::string dds_topic_of(const std::string& topic) {
    return "rt/" + topic;
}
inline constexpr const char* dds_type = "std_msgs::msg::dds_::UInt8MultiArray_";
inline constexpr const char* enclave = "enclave=/;";  // user data of a participant

// Of rclcpp: the default of topics, and of sensor data.
inline constexpr int reliable_depth = 10;
inline constexpr int best_effort_depth = 5;

}  // namespace romano::bench::ros
