// What plants, controllers and those who open loops say to each other: ROMANO messages of one type
// of the application's own. README.md has the octets and what they mean.
//
// Octets are views: after decoding they point into the received message and live as long as it
// does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

#include "romano/base/bytes.h"
#include "romano/message/romano_id.h"

namespace romano::control {

using message::RomanoId;

inline constexpr std::uint8_t data_type = 0xC0;
inline constexpr std::size_t most_parameters = 32;  // octets of a law's
inline constexpr std::size_t most_value = 64;       // octets of a sample or a command
inline constexpr std::size_t largest_message = 17 + most_value;

/// A sensor with its actuator, at one plant.
enum class Channel : std::uint8_t {};
enum class Law : std::uint16_t {};
/// One loop from its opening to its end; before, it is the channel's ticket.
enum class Session : std::uint32_t { none = 0 };

/// What a plant does without a command.
enum class Fallback : std::uint8_t { stop, hold, own_law };

enum class State : std::uint8_t { free, inviting, waiting, controlled };

enum class Reason : std::uint8_t {
    none,
    wrong_ticket,
    no_such_channel,
    busy,
    impossible_settings,
    no_answer,  // of the controller
    no_such_law,
    controller_full,
    session_in_use,  // at the controller
    ended_by_a_node,
    lease_over,
    fell_back,  // and was told to end then
    no_such_loop,
    not_allowed,  // by the robot itself
};
[[nodiscard]] std::string_view name_of(State state);
/// In words, for people.
[[nodiscard]] std::string_view name_of(Reason reason);

struct Ask {
    Channel channel;
    RomanoId asker;
};

struct Open {
    Channel channel;
    Session ticket;
    RomanoId asker;
    RomanoId controller;
    Law law;
    std::uint16_t period_ms;
    std::uint16_t deadline_ms;
    std::uint16_t lease_s;  // 0: no end
    Fallback fallback;
    bool ends_then;  // the loop, as it falls back
    Bytes parameters;
};

struct Renew {
    Session session;
    RomanoId asker;
};

struct End {
    Session session;
    RomanoId asker;
};

/// Microseconds.
struct Ages {
    std::uint32_t last = 0;
    std::uint32_t least = 0;
    std::uint32_t smoothed = 0;
    std::uint32_t greatest = 0;
    std::uint32_t jitter = 0;
};

struct LoopCounters {
    std::uint32_t samples = 0;   // sent
    std::uint32_t accepted = 0;  // commands carried out
    std::uint32_t late = 0;
    std::uint32_t repeated = 0;
    std::uint32_t foreign = 0;
    std::uint32_t falls = 0;  // back, for want of a command
};

struct Report {
    Channel channel;
    Session session;
    RomanoId plant;
    RomanoId controller;
    State state;
    Reason reason;
    LoopCounters counters;
    Ages ages;
};

struct Invite {
    Session session;
    RomanoId plant;
    Channel channel;
    Law law;
    std::uint16_t period_ms;
    std::uint16_t deadline_ms;
    Bytes parameters;
};

struct Answer {
    Session session;
    Reason reason;  // none: accepted
};

struct Sample {
    static constexpr std::uint16_t no_age = 0xFFFF;

    Session session;
    std::uint32_t sequence;
    std::uint32_t tick;
    std::uint16_t age;  // of the last command when it was carried out, 0.1 ms
    Bytes value;
};

struct Command {
    Session session;
    std::uint32_t sequence;  // as in the sample
    std::uint32_t tick;      // as in the sample
    Bytes value;
};

struct Bye {
    Session session;
    Reason reason;
};

using Message = std::variant<Ask, Open, Renew, End, Report, Invite, Answer, Sample, Command, Bye>;

/// Octet 0 says that it belongs to a loop; everything else can still be wrong.
[[nodiscard]] inline bool is_of_a_loop(Bytes message) {
    return !message.empty() && message[0] == data_type;
}

/// Total: any octets are a message or nothing.
[[nodiscard]] std::optional<Message> decode(Bytes message);

/// Writes `message` to the front of `out` and returns its size; 0 when it does not fit or its
/// octets are too many.
[[nodiscard]] std::size_t encode(const Ask& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Open& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Renew& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const End& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Report& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Invite& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Answer& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Sample& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Command& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Bye& message, MutableBytes out);

}  // namespace romano::control
