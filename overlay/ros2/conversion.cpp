#include "overlay/ros2/conversion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "romano/message/codec.h"

namespace romano::ros2 {
namespace {

using message::MovementType;
using message::SensorData;
using message::SensorType;

constexpr double millis = 1000;
constexpr double radians_per_millidegree = std::numbers::pi / 180 / millis;
constexpr std::size_t longest_payload = 65'535;  // more never fits a datagram

std::int32_t i32(Bytes octets, std::size_t at) {
    const std::uint32_t value =
        static_cast<std::uint32_t>(be16(octets, at)) << 16U | be16(octets, at + 2);
    return static_cast<std::int32_t>(value);
}

std::uint32_t u32(Bytes octets, std::size_t at) {
    return static_cast<std::uint32_t>(i32(octets, at));
}

void put_u32(MutableBytes out, std::size_t at, std::uint32_t value) {
    put_be16(out, at, static_cast<std::uint16_t>(value >> 16U));
    put_be16(out, at + 2, static_cast<std::uint16_t>(value & 0xFFFFU));
}

/// A whole number of that type, if the value is near one.
template <typename Whole>
std::optional<Whole> whole(double value) {
    const double rounded = std::round(value);
    if (!(rounded >= static_cast<double>(std::numeric_limits<Whole>::min()) &&
          rounded <= static_cast<double>(std::numeric_limits<Whole>::max()))) {
        return std::nullopt;
    }
    return static_cast<Whole>(rounded);
}

Header header_of(const Rule& rule, std::string_view wild_part, std::uint64_t unix_ms) {
    constexpr std::uint64_t last_second = std::numeric_limits<std::int32_t>::max();
    return {.sec = static_cast<std::int32_t>(std::min(unix_ms / 1000, last_second)),
            .nanosec = static_cast<std::uint32_t>(unix_ms % 1000) * 1'000'000,
            .frame_id = filled(rule.frame, wild_part)};
}

/// The value of a sensor of that kind and size.
std::optional<Bytes> sensor_value(Bytes payload, SensorType type, std::size_t size) {
    const auto decoded = message::decode(payload);
    if (!decoded) return std::nullopt;
    const auto* data = std::get_if<SensorData>(&decoded.value());
    if (data == nullptr || data->type != type || data->value.size() != size) return std::nullopt;
    return data->value;
}

std::optional<RosMessage> odometry(Bytes payload, const Rule& rule, std::string_view wild_part,
                                   std::uint64_t unix_ms, const Twist& speed) {
    const auto place = sensor_value(payload, SensorType::location, 12);
    if (!place) return std::nullopt;
    const double half_heading = i32(*place, 8) * radians_per_millidegree / 2;
    return Odometry{
        .header = header_of(rule, wild_part, unix_ms),
        .child_frame_id = filled(rule.child_frame, wild_part),
        .position = {i32(*place, 0) / millis, i32(*place, 4) / millis, 0},
        .orientation = {0, 0, std::sin(half_heading), std::cos(half_heading)},
        .twist = speed,
    };
}

std::optional<RosMessage> battery(Bytes payload, const Rule& rule, std::string_view wild_part,
                                  std::uint64_t unix_ms) {
    const auto value = sensor_value(payload, SensorType::battery, 2);
    if (!value) return std::nullopt;
    const double volts = be16(*value, 0) / millis;
    BatteryState out{.header = header_of(rule, wild_part, unix_ms),
                     .voltage = static_cast<float>(volts)};
    if (rule.full > rule.empty) {
        const double part = (volts - rule.empty) / (rule.full - rule.empty);
        out.percentage = static_cast<float>(std::clamp(part, 0.0, 1.0));
    }
    return out;
}

std::optional<RosMessage> range(Bytes payload, const Rule& rule, std::string_view wild_part,
                                std::uint64_t unix_ms) {
    const auto value = sensor_value(payload, SensorType::proximity, 4);
    if (!value) return std::nullopt;
    return Range{.header = header_of(rule, wild_part, unix_ms),
                 .radiation_type = rule.radiation_type,
                 .field_of_view = static_cast<float>(rule.field_of_view),
                 .min_range = static_cast<float>(rule.min_range),
                 .max_range = static_cast<float>(rule.max_range),
                 .range = static_cast<float>(u32(*value, 0) / millis)};
}

/// ROS 2's strings are UTF-8 and end at a zero.
bool is_text(Bytes octets) {
    std::size_t at = 0;
    while (at < octets.size()) {
        const std::uint8_t first = octets[at++];
        if (first == 0) return false;
        if (first < 0x80) continue;
        const std::size_t more = first >= 0xF0 ? 3 : first >= 0xE0 ? 2 : 1;
        if (first < 0xC2 || first > 0xF4 || octets.size() - at < more) return false;
        std::uint32_t point = first & (0x3FU >> more);
        for (std::size_t i = 0; i < more; ++i, ++at) {
            if ((octets[at] & 0xC0U) != 0x80) return false;
            point = point << 6U | (octets[at] & 0x3FU);
        }
        const bool is_overlong = (more == 2 && point < 0x800) || (more == 3 && point < 0x10000);
        if (is_overlong || (point >= 0xD800 && point <= 0xDFFF) || point > 0x10FFFF) return false;
    }
    return true;
}

// --- to ROMANO

template <typename Content>
void add(std::vector<Payload>& out, const Content& content) {
    Payload octets(message::max_message);
    octets.resize(message::encode(content, octets));
    if (!octets.empty()) out.push_back(std::move(octets));
}

void add_sensor(std::vector<Payload>& out, SensorType type, Bytes value) {
    add(out, SensorData{.type = type, .value = value});
}

/// One of a pair of movements, by the sign; false when it cannot be said.
bool add_movement(std::vector<Payload>& out, double amount, MovementType positive,
                  MovementType negative) {
    const auto size = whole<std::uint32_t>(std::abs(amount));
    if (!size) return false;
    if (*size == 0) return true;
    std::array<std::uint8_t, 4> arguments{};
    put_u32(arguments, 0, *size);
    add(out,
        message::MovementControl{.type = amount > 0 ? positive : negative, .arguments = arguments});
    return true;
}

std::vector<Payload> movements(const Twist& twist, const Rule& rule) {
    const double seconds = std::chrono::duration<double>(rule.step).count();
    std::vector<Payload> out;
    const bool fits = add_movement(out, twist.linear.x * millis * seconds, MovementType::front,
                                   MovementType::back) &&
                      add_movement(out, twist.linear.y * millis * seconds, MovementType::left,
                                   MovementType::right) &&
                      add_movement(out, twist.angular.z / radians_per_millidegree * seconds,
                                   MovementType::rotate_left, MovementType::rotate_right);
    if (!fits) return {};
    if (out.empty()) {  // stop
        constexpr std::array<std::uint8_t, 4> nowhere{};
        add(out, message::MovementControl{.type = MovementType::front, .arguments = nowhere});
    }
    return out;
}

std::vector<Payload> place_and_speed(const Odometry& odometry) {
    const Quaternion& q = odometry.orientation;
    // The turn about z of whatever turns it says.
    const double heading = std::atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z));
    const auto x = whole<std::int32_t>(odometry.position.x * millis);
    const auto y = whole<std::int32_t>(odometry.position.y * millis);
    const auto turned = whole<std::int32_t>(heading / radians_per_millidegree);
    const auto ahead = whole<std::int32_t>(odometry.twist.linear.x * millis);
    const auto turning = whole<std::int32_t>(odometry.twist.angular.z / radians_per_millidegree);
    if (!x || !y || !turned || !ahead || !turning) return {};
    std::array<std::uint8_t, 12> place{};
    put_u32(place, 0, static_cast<std::uint32_t>(*x));
    put_u32(place, 4, static_cast<std::uint32_t>(*y));
    put_u32(place, 8, static_cast<std::uint32_t>(*turned));
    std::array<std::uint8_t, 8> speed{};
    put_u32(speed, 0, static_cast<std::uint32_t>(*ahead));
    put_u32(speed, 4, static_cast<std::uint32_t>(*turning));
    std::vector<Payload> out;
    add_sensor(out, SensorType::speed, speed);  // first: whoever joins them waits for the place
    add_sensor(out, SensorType::location, place);
    return out;
}

std::vector<Payload> millivolts(const BatteryState& state) {
    const auto value = whole<std::uint16_t>(state.voltage * millis);
    if (!value) return {};
    std::array<std::uint8_t, 2> octets{};
    put_be16(octets, 0, *value);
    std::vector<Payload> out;
    add_sensor(out, SensorType::battery, octets);
    return out;
}

std::vector<Payload> proximity(const Range& range) {
    const auto value = whole<std::uint32_t>(range.range * millis);
    if (!value) return {};
    std::array<std::uint8_t, 4> octets{};
    put_u32(octets, 0, *value);
    std::vector<Payload> out;
    add_sensor(out, SensorType::proximity, octets);
    return out;
}

std::vector<Payload> as_they_are(Bytes octets) {
    if (octets.size() > longest_payload) return {};
    return {Payload{octets.begin(), octets.end()}};
}

}  // namespace

std::optional<Motion> motion_of(const message::MovementControl& movement, const Rule& rule) {
    const auto amount = message::amount_of(movement);
    if (!amount) return std::nullopt;
    Motion out{};
    double seconds = *amount / millis / rule.speed;
    switch (movement.type) {
        case MovementType::front:
            out.velocity.linear.x = rule.speed;
            break;
        case MovementType::back:
            out.velocity.linear.x = -rule.speed;
            break;
        case MovementType::left:
            out.velocity.linear.y = rule.speed;
            break;
        case MovementType::right:
            out.velocity.linear.y = -rule.speed;
            break;
        case MovementType::rotate_left:
        case MovementType::rotate_right:
            seconds = *amount * radians_per_millidegree / rule.turn;
            out.velocity.angular.z =
                movement.type == MovementType::rotate_left ? rule.turn : -rule.turn;
            break;
        default:
            return std::nullopt;
    }
    out.time = std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds));
    return out;
}

std::optional<Twist> twist_of(const SensorData& speed) {
    if (speed.type != SensorType::speed || speed.value.size() != 8) return std::nullopt;
    Twist out;
    out.linear.x = i32(speed.value, 0) / millis;
    out.angular.z = i32(speed.value, 4) * radians_per_millidegree;
    return out;
}

std::optional<RosMessage> to_ros(Bytes payload, const Rule& rule, std::string_view wild_part,
                                 std::uint64_t unix_ms, const Twist& speed) {
    switch (rule.type) {
        case RosType::twist:
            break;
        case RosType::odometry:
            return odometry(payload, rule, wild_part, unix_ms, speed);
        case RosType::battery_state:
            return battery(payload, rule, wild_part, unix_ms);
        case RosType::range:
            return range(payload, rule, wild_part, unix_ms);
        case RosType::string:
            if (!is_text(payload)) return std::nullopt;
            return String{std::string{as_text(payload)}};
        case RosType::uint8_multi_array:
            return UInt8MultiArray{{payload.begin(), payload.end()}};
    }
    return std::nullopt;
}

std::vector<Payload> to_romano(const RosMessage& message, const Rule& rule) {
    if (const auto* twist = std::get_if<Twist>(&message)) return movements(*twist, rule);
    if (const auto* odometry = std::get_if<Odometry>(&message)) return place_and_speed(*odometry);
    if (const auto* state = std::get_if<BatteryState>(&message)) return millivolts(*state);
    if (const auto* range = std::get_if<Range>(&message)) return proximity(*range);
    if (const auto* text = std::get_if<String>(&message)) return as_they_are(as_octets(text->data));
    return as_they_are(std::get<UInt8MultiArray>(message).data);
}

}  // namespace romano::ros2
