// ROS 2 messages to and from the C types that idlc makes of ros_types.idl and humble_types.idl.
#pragma once

#include <dds/dds.h>

#include "overlay/ros2/ros_messages.h"
#include "overlay/ros2/ros_types.h"

namespace romano::ros2 {

[[nodiscard]] const dds_topic_descriptor_t& descriptor_of(RosType type, Release release);

/// Of a writer of the message's type.
dds_return_t write(dds_entity_t writer, const RosMessage& message, Release release);

/// `sample`: taken from a reader of that type.
[[nodiscard]] RosMessage message_in(const void* sample, RosType type, Release release);

}  // namespace romano::ros2
