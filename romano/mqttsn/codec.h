// Octets to messages and back: MQTT-SN 1.2 section 5, all messages, without a heap.
//
// Decoding is total: any octets give a message or the reason why they are none. The datagram's
// size is the truth; the length on the wire is a claim that is checked first. Encoding takes the
// short form of the length whenever it fits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "romano/base/bytes.h"
#include "romano/base/result.h"
#include "romano/mqttsn/messages.h"

namespace romano::mqttsn {

/// Why a datagram is no message.
enum class Malformed : std::uint8_t {
    empty,           // no octet at all
    length,          // the length claims another size than the datagram has, or a size under 2
    reserved_type,   // MsgType is none of section 5.2.2
    size,            // the size is not possible for this type
    reserved_value,  // a field holds a value that the section reserves
};
inline constexpr std::size_t malformed_kinds = 5;

template <typename T>
using Decoded = Result<T, Malformed>;

/// One datagram, one message (5.2.1d). Views in the message point into `datagram`.
[[nodiscard]] Decoded<Message> decode(Bytes datagram);

/// Writes `message` to the front of `out`. Returns its size, or 0 when `out` is too small.
[[nodiscard]] std::size_t encode(const Message& message, MutableBytes out);

/// As encode(Message), for the hot path: no variant is built.
[[nodiscard]] std::size_t encode(const Publish& message, MutableBytes out);

/// The size that encode() will write.
[[nodiscard]] std::size_t encoded_size(const Message& message);
[[nodiscard]] std::size_t encoded_size(const Publish& message);

/// The specification's name, "PUBLISH"; for traces and counters.
[[nodiscard]] std::string_view name_of(MsgType type);
[[nodiscard]] MsgType type_of(const Message& message);

}  // namespace romano::mqttsn
