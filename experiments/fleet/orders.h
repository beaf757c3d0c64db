// What an operator says to robots of the picture, as messages on their topics. What cannot be said
// is refused by std::invalid_argument with one sentence.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "experiments/fleet/fleet_picture.h"
#include "experiments/operator/robot_message.h"
#include "romano/message/romano_id.h"
#include "romano/mqttsn/types.h"

namespace romano::experiments {

struct Order {
    std::string topic;
    Octets octets;
    mqttsn::Qos qos;
};

struct Orders {
    std::string words;                      // for people
    std::vector<message::RomanoId> robots;  // for whom it is meant
    std::vector<Order> orders;
    bool ends_loops = false;  // in which others control these robots
};

/// As `romano move` does, in the robot's own form, carried out exactly once.
[[nodiscard]] Orders move_orders(const SeenRobot& robot, std::string_view movement,
                                 std::string_view amount);

/// Stands still: a movement of nothing takes the place of what the robot does. A robot of the
/// authors' firmware drives for no time at no speed.
[[nodiscard]] Orders stop_orders(const SeenRobot& robot);

/// First to all at once on `common`, in each form that a robot of the picture has; then to each by
/// itself, whatever it listens to.
[[nodiscard]] Orders stop_all_orders(const FleetPicture& picture);

}  // namespace romano::experiments
