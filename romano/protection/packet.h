// The octets of MQTT-SN 2.0's Protection Encapsulation, with AES-CCM-64-128 and a 32-bit counter:
// the table in the README. Which draft: there, too.
//
// The datagram's size is the truth. Nothing here is verified: a packet is sealed, or opened, by the
// ends (robot_end.h, broker_end.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "romano/base/bytes.h"
#include "romano/base/result.h"
#include "romano/mqttsn/types.h"
#include "romano/protection/keys.h"
#include "romano/protection/refusal.h"

namespace romano::protection {

inline constexpr auto packet_type = mqttsn::MsgType{0xFF};  // reserved in MQTT-SN 1.2
inline constexpr std::size_t tag_size = 8;
inline constexpr std::size_t fields_size = 1 + 1 + 8 + 4 + 4;  // between type and message

/// What a packet is longer than its message, at most.
inline constexpr std::size_t most_overhead = 4 + fields_size + tag_size;

using SenderId = std::array<std::uint8_t, 8>;

/// As the draft has it: the first octets of the client id's SHA-256.
[[nodiscard]] SenderId sender_id(std::string_view client_id);

/// Names a robot's run by the number of its first packet, or of one before. In the draft this is
/// the random number.
enum class RunId : std::uint32_t {};

struct Fields {
    SenderId sender;
    RunId run;
    std::uint32_t number;
};

/// Views point into the datagram.
struct Packet {
    Bytes header;         // all before the message: readable, and authenticated
    MutableBytes sealed;  // message and tag

    [[nodiscard]] Fields fields() const;
    [[nodiscard]] MutableBytes message() const { return sealed.first(sealed.size() - tag_size); }
    [[nodiscard]] Bytes tag() const { return sealed.last(tag_size); }
};

[[nodiscard]] Result<Packet, Refusal> parse(MutableBytes datagram);

/// Writes a packet whose message is encrypted and returns its size; 0 when `out` is too small,
/// or there is no message.
/// `message` may lie in `out`.
[[nodiscard]] std::size_t write(const Fields& fields, Bytes message, const Key& key,
                                MutableBytes out);

/// Decrypts the message where it lies; false when the tag is wrong.
[[nodiscard]] bool open(const Packet& packet, const Key& key);

/// As the draft has it: the first octets of the header's SHA-256.
using Nonce = std::array<std::uint8_t, 13>;
[[nodiscard]] Nonce nonce_of(Bytes header);

}  // namespace romano::protection
