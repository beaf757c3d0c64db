// ROMANO messages become ROS 2 messages and back: millimetres, millidegrees and millivolts here,
// metres, radians and volts there. A movement of the paper's kind has a distance and no time, a
// Twist has neither: it becomes a velocity with an end, and a velocity that is driven for
// `rule.step` becomes a distance.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "overlay/ros2/ros_messages.h"
#include "overlay/ros2/rules.h"
#include "romano/base/bytes.h"
#include "romano/base/time.h"
#include "romano/message/messages.h"

namespace romano::ros2 {

/// A movement as ROS 2 drives it.
struct Motion {
    Twist velocity;
    Duration time{};  // then it stops; 0: at once
};

/// Nothing for a movement of the application's own.
[[nodiscard]] std::optional<Motion> motion_of(const message::MovementControl& movement,
                                              const Rule& rule);

/// The speed that a robot tells beside its location: along its heading, and turning.
[[nodiscard]] std::optional<Twist> twist_of(const message::SensorData& speed);

/// What a rule makes of a payload, at once: all types but Twist. `speed` goes into Odometry.
/// Nothing when the payload is nothing of the rule's type.
[[nodiscard]] std::optional<RosMessage> to_ros(Bytes payload, const Rule& rule,
                                               std::string_view wild_part, std::uint64_t unix_ms,
                                               const Twist& speed);

using Payload = std::vector<std::uint8_t>;

/// What a rule makes of a ROS 2 message: payloads to be published in this order. None when no
/// ROMANO message can say it: not a number, out of range, too long.
[[nodiscard]] std::vector<Payload> to_romano(const RosMessage& message, const Rule& rule);

}  // namespace romano::ros2
