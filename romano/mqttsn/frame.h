// The frame around every message: MQTT-SN 1.2 section 5.2.1, and 5.5 for a forwarder's wrapping.
//
// Two forms of the length: one octet, or 0x01 and two octets. The datagram's size is the truth and
// the length a claim. What the frame says about the type is looked at in decode.h.
#pragma once

#include <cstddef>
#include <cstdint>

#include "romano/base/bytes.h"
#include "romano/base/result.h"
#include "romano/mqttsn/types.h"

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

/// Views point into the datagram.
struct Frame {
    MsgType type;   // may still be a reserved value
    Bytes body;     // what stands behind MsgType
    Bytes wrapped;  // the message behind a forwarder's header; else empty
};

[[nodiscard]] Decoded<Frame> decode_frame(Bytes datagram);

/// The size of a whole message: the short form of the length whenever it fits (5.2.1c).
[[nodiscard]] constexpr std::size_t framed_size(std::size_t body_size) {
    return body_size + 2 <= 255 ? body_size + 2 : body_size + 4;
}

/// Writes length and type to the front of `out`. Returns where the body belongs, or nullptr when
/// the message does not fit `out` or the length field.
[[nodiscard]] std::uint8_t* begin_frame(MsgType type, std::size_t body_size, MutableBytes out);

}  // namespace romano::mqttsn
