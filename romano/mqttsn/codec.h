// Octets to messages and back: MQTT-SN 1.2 section 5, all messages, without a heap.
//
// Decoding is total: any octets give a message or the reason why they are none. The datagram's
// size is the truth; the length on the wire is a claim that is checked first. Encoding takes the
// short form of the length whenever it fits.
//
// For a receiver that wants only some messages and not the code of all: decode.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "romano/base/bytes.h"
#include "romano/mqttsn/frame.h"
#include "romano/mqttsn/messages.h"

namespace romano::mqttsn {

/// One datagram, one message (5.2.1d). Views in the message point into `datagram`.
[[nodiscard]] Decoded<Message> decode(Bytes datagram);

/// Writes `message` to the front of `out`. Returns its size, or 0 when `out` is too small or the
/// message too long for its length field. `message` may not lie in `out`.
[[nodiscard]] std::size_t encode(const Message& message, MutableBytes out);

/// As encode(Message) where the type is known: no variant is built, and a device links only the
/// encoders that it calls.
[[nodiscard]] std::size_t encode(const Advertise& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Searchgw& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Gwinfo& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Connect& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Connack& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Willtopicreq& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Willtopic& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Willmsgreq& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Willmsg& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Register& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Regack& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Publish& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Puback& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Pubcomp& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Pubrec& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Pubrel& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Subscribe& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Suback& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Unsubscribe& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Unsuback& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Pingreq& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Pingresp& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Disconnect& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Willtopicupd& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Willtopicresp& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Willmsgupd& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Willmsgresp& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Encapsulated& message, MutableBytes out);

/// The size that encode() will write.
[[nodiscard]] std::size_t encoded_size(const Message& message);
[[nodiscard]] std::size_t encoded_size(const Publish& message);

/// The specification's name, "PUBLISH"; for traces and counters.
[[nodiscard]] std::string_view name_of(MsgType type);
[[nodiscard]] MsgType type_of(const Message& message);

}  // namespace romano::mqttsn
