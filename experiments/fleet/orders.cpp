#include "experiments/fleet/orders.h"

#include <algorithm>
#include <utility>

#include "romano/server/server.h"

namespace romano::experiments {
namespace {

using mqttsn::Qos;

constexpr int full_speed = 30;  // of the authors' firmware, as `romano move` has it

Octets stop_message(Form form) {
    return move_message(form, "front", form == Form::legacy ? "0ms" : "0mm", 0);
}

/// Doubled it does no harm, and so it need not wait for the second half of QoS 2.
Order stop_order(const SeenRobot& robot) {
    return {.topic = std::string{robot.entry.id.text()},
            .octets = stop_message(robot.entry.form),
            .qos = Qos::at_least_once};
}

}  // namespace

Orders move_orders(const SeenRobot& robot, std::string_view movement, std::string_view amount) {
    Octets octets = move_message(robot.entry.form, movement, amount, full_speed);
    return {.words = "move " + std::string{movement} + ' ' + std::string{amount},
            .robots = {robot.entry.id},
            .orders = {{.topic = std::string{robot.entry.id.text()},
                        .octets = std::move(octets),
                        .qos = Qos::exactly_once}}};
}

Orders stop_orders(const SeenRobot& robot) {
    return {.words = "stop",
            .robots = {robot.entry.id},
            .orders = {stop_order(robot)},
            .ends_loops = true};
}

Orders stop_all_orders(const FleetPicture& picture) {
    Orders all{.words = "stop all", .robots = {}, .orders = {}, .ends_loops = true};
    all.orders.push_back({.topic = std::string{server::common_topic},
                          .octets = stop_message(Form::binary),
                          .qos = Qos::at_least_once});
    const auto is_legacy = [](const auto& one) { return one.second.entry.form == Form::legacy; };
    if (std::ranges::any_of(picture.robots(), is_legacy)) {
        all.orders.push_back({.topic = std::string{server::common_topic},
                              .octets = stop_message(Form::legacy),
                              .qos = Qos::at_least_once});
    }
    for (const auto& [id, robot] : picture.robots()) {
        all.robots.push_back(id);
        all.orders.push_back(stop_order(robot));
    }
    return all;
}

}  // namespace romano::experiments
