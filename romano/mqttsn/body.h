// The bodies of MQTT-SN 1.2 section 5.4 as data: which of a few fields stand behind each MsgType,
// always in the same order. One reader and one writer for all messages, for devices where a
// function each (decode.h, encode.h) takes too much flash.
//
// Not here: what CONNECT says to a broker, and a forwarder's wrapping (5.5).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "romano/base/bytes.h"
#include "romano/mqttsn/types.h"

namespace romano::mqttsn {

/// What a message does not have stays as it is here when read, and is left out when written: an
/// answer can be written from the body of its request.
struct Body {
    std::uint8_t flags = 0;  // of the discovery messages: the gateway's id, the radius
    ReturnCode code = ReturnCode::accepted;
    TopicId topic_id{};  // octets 0 and 1 of a short name too
    MsgId msg_id{};      // of CONNECT, DISCONNECT and ADVERTISE: the duration, seconds
    Bytes rest{};        // text or octets up to the end of the message
};

constexpr Qos qos_in(std::uint8_t flags) {
    return static_cast<Qos>((flags >> 5U) & 3U);
}
constexpr TopicIdType topic_type_in(std::uint8_t flags) {
    return static_cast<TopicIdType>(flags & 3U);
}

/// Nothing when `octets` cannot be the body of that type by their size. `rest` points into them.
[[nodiscard]] std::optional<Body> read_body(MsgType type, Bytes octets);

/// Writes the whole message to the front of `out`. Returns its size, or 0 when it does not fit.
[[nodiscard]] std::size_t write_message(MsgType type, const Body& body, MutableBytes out);

}  // namespace romano::mqttsn
