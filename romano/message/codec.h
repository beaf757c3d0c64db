// ROMANO messages to octets and back, without a heap. Decoding is total: any
// octets give a message or the reason why they are none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "romano/base/bytes.h"
#include "romano/base/result.h"
#include "romano/message/messages.h"

namespace romano::message {

enum class Malformed : std::uint8_t {
    header,         // fewer than two octets
    length,         // the length octet differs from the received size
    reserved_type,  // 0x0D to 0x10
    size,           // not possible for this type
    value,          // a field holds what it may not: an id that is none, a reserved
                    // movement
};
inline constexpr std::size_t malformed_kinds = 5;

[[nodiscard]] Result<Message, Malformed> decode(Bytes data);

/// Why `data` is no message; nothing when it is one. decode() without a value,
/// for receivers that want a few messages and not the code of all: octet 0 is
/// the DataType, and these read the rest of a message without a flaw.
[[nodiscard]] std::optional<Malformed> flaw_of(Bytes data);
[[nodiscard]] MovementControl movement_in(Bytes message);
[[nodiscard]] std::string_view topic_in(Bytes message);  // MqttSubscribe, MqttUnsubscribe
[[nodiscard]] MqttPublishRequest publish_request_in(Bytes message);

/// Writes `message` to the front of `out`. Returns its size, 2 to 255 octets; 0
/// when it is longer, does not fit, or would not decode again.
[[nodiscard]] std::size_t encode(const Message& message, MutableBytes out);

/// As encode(Message) where the type is known: no variant is built, and a
/// device links only the encoders that it calls.
[[nodiscard]] std::size_t encode(const NormalData& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const MqttSubscribe& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const MqttPublishRequest& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const ConnectedNodes& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const RequestConnectedNodes& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const RssiReport& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const SensorData& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const MovementControl& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const RemoteControl& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const MqttUnsubscribe& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const Heartbeat& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const ConnectionRequest& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const ConnectionAck& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const UdpSendReq& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const UdpSendGo& message, MutableBytes out);
[[nodiscard]] std::size_t encode(const ApplicationData& message, MutableBytes out);

/// The argument of the six standard movements: mm or millidegrees. Empty for
/// the application's own.
[[nodiscard]] std::optional<std::uint32_t> amount_of(const MovementControl& movement);

}  // namespace romano::message
