#include "experiments/operator/robot_message.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "experiments/operator/movements.h"
#include "romano/message/codec.h"
#include "romano/message/romano_id.h"
#include "romano/mqttsn/topic.h"

namespace romano::experiments {
namespace {

constexpr std::size_t legacy_topic_octets = 15;
constexpr std::size_t legacy_data_octets = 31;

[[noreturn]] void refuse(const std::string& sentence) {
    throw std::invalid_argument(sentence);
}

std::string in_quotes(std::string_view text) {
    return '`' + std::string{text} + '`';
}

struct Unit {
    std::string_view name;
    double factor;
};

/// "12.5cm" in the smallest of `units`; empty when it is none of them.
template <std::size_t Count>
std::optional<double> amount_in(std::string_view text, const std::array<Unit, Count>& units) {
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{}) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    for (const Unit& unit : units) {
        if (text == unit.name) return number * unit.factor;
    }
    return std::nullopt;
}

template <typename Number>
Number whole(double value, double most, std::string_view text) {
    if (!(value >= 0) || value > most) {
        refuse("amount " + in_quotes(text) + ": must be from 0 to " +
               std::to_string(std::llround(most)) + " of the smallest unit");
    }
    return static_cast<Number>(std::llround(value));
}

constexpr std::array<Unit, 3> lengths = {{{"mm", 1}, {"cm", 10}, {"m", 1000}}};
constexpr std::array<Unit, 2> angles = {{{"mdeg", 1}, {"deg", 1000}}};
constexpr std::array<Unit, 2> times = {{{"ms", 1}, {"s", 1000}}};

Octets encoded(const message::Message& message) {
    std::array<std::uint8_t, message::max_message> octets{};
    const std::size_t size = message::encode(message, octets);
    if (size == 0) refuse("this is more than the 255 octets of a ROMANO message, or empty");
    return {octets.begin(), octets.begin() + static_cast<std::ptrdiff_t>(size)};
}

Octets own_movement(std::uint16_t type, std::string_view amount) {
    Octets arguments;
    for (std::size_t at = 0; at < amount.size(); at += 2) {
        std::uint8_t octet = 0;
        const char* begin = amount.data() + at;
        const auto [end, error] =
            std::from_chars(begin, amount.data() + std::min(at + 2, amount.size()), octet, 16);
        if (error != std::errc{} || end != begin + 2) {
            refuse("amount " + in_quotes(amount) +
                   ": the application's own movements take hexadecimal octets, for example 0a0b");
        }
        arguments.push_back(octet);
    }
    return encoded(message::MovementControl{message::MovementType{type}, arguments});
}

std::optional<std::uint16_t> own_movement_type(std::string_view movement) {
    if (!movement.starts_with("0x")) return std::nullopt;
    std::uint16_t type = 0;
    const char* end = movement.data() + movement.size();
    const auto [stop, error] = std::from_chars(movement.data() + 2, end, type, 16);
    if (error != std::errc{} || stop != end || type < 0x8000) return std::nullopt;
    return type;
}

std::size_t index_of(std::string_view movement) {
    for (std::size_t i = 0; i < movements.size(); ++i) {
        if (movements[i] == movement) return i;
    }
    refuse("movement " + in_quotes(movement) +
           ": must be front, back, left, right, rotate-left, rotate-right, or 0x8000 to 0xffff");
}

Octets binary_move(std::size_t movement, std::string_view amount) {
    const bool turns = movement >= 4;
    const auto value = turns ? amount_in(amount, angles) : amount_in(amount, lengths);
    if (!value) {
        refuse("amount " + in_quotes(amount) + ": " +
               (turns ? "must be an angle, for example 90deg or 1500mdeg"
                      : "must be a distance, for example 100mm, 10cm or 0.5m"));
    }
    const auto number = whole<std::uint32_t>(*value, 4'294'967'295.0, amount);
    std::array<std::uint8_t, 4> octets{};
    for (unsigned i = 0; i < 4; ++i) {
        octets[i] = static_cast<std::uint8_t>(number >> (24U - 8U * i));
    }
    return encoded(message::MovementControl{static_cast<message::MovementType>(movement), octets});
}

Octets text_octets(std::string_view text) {
    if (text.size() > legacy_data_octets || text.find('\0') != std::string_view::npos) {
        refuse("the authors' firmware takes at most 31 octets without NUL in a message");
    }
    return {text.begin(), text.end()};
}

void check_name(std::string_view what, std::string_view topic) {
    if (mqttsn::is_valid_topic_name(topic)) return;
    refuse(std::string{what} + ' ' + in_quotes(topic) +
           ": must be a topic's name: UTF-8, not empty, without + and #");
}

void check_filter(std::string_view topic) {
    if (mqttsn::is_valid_topic_filter(topic)) return;
    refuse("topic " + in_quotes(topic) +
           ": must be UTF-8 and not empty, with + as a whole level and # as the last one");
}

void check_legacy_topic(std::string_view topic) {
    if (topic.empty() || topic.size() > legacy_topic_octets) {
        refuse("topic " + in_quotes(topic) + ": the authors' firmware takes 1 to 15 octets");
    }
}

/// `7`, then hexadecimal: type (2 digits), time (4), degrees (4, signed), speed (2, signed).
Octets legacy_move(std::size_t movement, std::string_view amount, int speed) {
    constexpr unsigned rotate = 2;
    constexpr unsigned drive = 4;
    unsigned type = drive;
    std::uint16_t time = 0;
    std::int16_t degrees = 0;
    if (movement >= 4) {
        const auto angle = amount_in(amount, angles);
        if (!angle) refuse("amount " + in_quotes(amount) + ": must be an angle, for example 90deg");
        type = rotate;
        degrees = whole<std::int16_t>(*angle / 1000, 32'767, amount);
        if (movement == 5) degrees = static_cast<std::int16_t>(-degrees);
    } else if (movement >= 2) {
        refuse("the authors' firmware cannot drive sideways: rotate, then drive");
    } else {
        const auto duration = amount_in(amount, times);
        if (!duration) {
            refuse("amount " + in_quotes(amount) +
                   ": this robot has the authors' firmware, which drives by time: 500ms or 2s");
        }
        time = whole<std::uint16_t>(*duration, 65'535, amount);
        if (movement == 1) speed = -speed;
    }
    char text[16];
    std::snprintf(text, sizeof text, "7%02x%04x%04x%02x", type, unsigned{time},
                  static_cast<unsigned>(static_cast<std::uint16_t>(degrees)),
                  static_cast<unsigned>(speed) & 0xFFU);
    return text_octets(text);
}

}  // namespace

std::vector<std::string> receivers_in(std::string_view list) {
    std::vector<std::string> receivers;
    std::istringstream text{std::string{list}};
    for (std::string receiver; std::getline(text, receiver, ',');) {
        check_name("robot", receiver);
        std::string lower = receiver;
        std::ranges::transform(lower, lower.begin(), [](unsigned char letter) {
            return static_cast<char>(std::tolower(letter));
        });
        if (lower != receiver && message::RomanoId::parse(lower)) {
            refuse("robot " + in_quotes(receiver) + ": ids are in lower case: " + lower);
        }
        receivers.push_back(receiver);
    }
    if (receivers.empty()) check_name("robot", list);
    return receivers;
}

Octets move_message(Form form, std::string_view movement, std::string_view amount,
                    int legacy_speed) {
    if (const auto own = own_movement_type(movement)) {
        if (form == Form::legacy) refuse("the authors' firmware has no movements of applications");
        return own_movement(*own, amount);
    }
    const std::size_t index = index_of(movement);
    return form == Form::legacy ? legacy_move(index, amount, legacy_speed)
                                : binary_move(index, amount);
}

Octets subscribe_message(Form form, std::string_view topic) {
    check_filter(topic);
    if (form == Form::binary) return encoded(message::MqttSubscribe{topic});
    check_legacy_topic(topic);
    return text_octets("1" + std::string{topic});
}

Octets unsubscribe_message(Form form, std::string_view topic) {
    check_filter(topic);
    if (form == Form::legacy) refuse("the authors' firmware cannot unsubscribe");
    return encoded(message::MqttUnsubscribe{topic});
}

/// In the ASCII form the data is published as it stands: `0` makes it normal data for its readers.
Octets request_message(Form form, std::string_view topic, std::string_view data) {
    check_name("topic", topic);
    if (form == Form::binary) return encoded(message::MqttPublishRequest{topic, as_octets(data)});
    check_legacy_topic(topic);
    std::string text = "2";
    text += static_cast<char>('0' + topic.size());
    text += topic;
    text += '0';
    text += data;
    return text_octets(text);
}

}  // namespace romano::experiments
