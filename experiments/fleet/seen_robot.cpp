#include "experiments/fleet/seen_robot.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <variant>

#include "experiments/fleet/shown_text.h"
#include "experiments/operator/message_text.h"

namespace romano::experiments {
namespace {

constexpr std::chrono::seconds gap_counts_for{3};
constexpr double step_of_path_mm = 20;

std::int32_t signed_at(Bytes octets, std::size_t at) {
    return static_cast<std::int32_t>(std::uint32_t{be16(octets, at)} << 16U | be16(octets, at + 2));
}

double distance_mm(const Place& from, const Place& to) {
    return std::hypot(double{1} * to.x_mm - from.x_mm, double{1} * to.y_mm - from.y_mm);
}

}  // namespace

void SeenRobot::on_heard(Instant now, std::string_view topic, Bytes data) {
    if (heard) {
        const Duration gap = now - *heard;
        if (gap >= worst_gap_ || now - worst_gap_at_ > gap_counts_for) {
            worst_gap_ = gap;
            worst_gap_at_ = now;
        }
    }
    heard = now;
    ++messages_now_;
    keep(now, false, topic, data);
    const auto message = romano_message(topic, data);
    if (!message) return;
    if (std::holds_alternative<message::Heartbeat>(*message)) heartbeat = now;
    const auto* sensor = std::get_if<message::SensorData>(&*message);
    if (sensor == nullptr) return;
    if (sensor->type == message::SensorType::battery) battery_mv = be16(sensor->value, 0);
    if (sensor->type == message::SensorType::location) {
        placed_at = now;
        move_to(Place{.x_mm = signed_at(sensor->value, 0),
                      .y_mm = signed_at(sensor->value, 4),
                      .heading_mdeg = signed_at(sensor->value, 8)});
    }
}

void SeenRobot::on_said(Instant now, std::string_view topic, Bytes data) {
    ++told_now_;
    keep(now, true, topic, data);
}

bool SeenRobot::on_second() {
    const std::uint32_t sent_before =
        std::exchange(messages_per_s, std::exchange(messages_now_, 0));
    const std::uint32_t told_before = std::exchange(told_per_s, std::exchange(told_now_, 0));
    return sent_before != messages_per_s || told_before != told_per_s;
}

std::optional<Duration> SeenRobot::longest_silence(Instant now) const {
    if (worst_gap_ == Duration{0} || now - worst_gap_at_ > gap_counts_for) return std::nullopt;
    return worst_gap_;
}

void SeenRobot::keep(Instant now, bool to_robot, std::string_view topic, Bytes data) {
    RobotMessage message{.at = now,
                         .to_robot = to_robot,
                         .topic = shown_text(topic),
                         .text = shown_data(topic, data)};
    const auto before = std::ranges::find_if(messages, [&](const RobotMessage& one) {
        return one.to_robot == to_robot && one.topic == message.topic &&
               (!to_robot || one.text == message.text);
    });
    if (before != messages.end()) {
        message.times = before->times + 1;
        messages.erase(before);
    }
    messages.push_back(std::move(message));
    if (messages.size() > most_messages) messages.pop_front();
}

void SeenRobot::move_to(const Place& next) {
    place = next;
    if (!path.empty() && distance_mm(path.back(), next) < step_of_path_mm) return;
    path.push_back(next);
    if (path.size() > most_places) path.pop_front();
}

}  // namespace romano::experiments
