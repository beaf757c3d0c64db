// The small numbers of MQTT-SN 1.2: message types, flags, ids, return codes, timers.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace romano::mqttsn {

/// MQTT-SN 1.2 section 5.2.2. Values that are not listed are reserved.
enum class MsgType : std::uint8_t {
    advertise = 0x00,
    searchgw = 0x01,
    gwinfo = 0x02,
    connect = 0x04,
    connack = 0x05,
    willtopicreq = 0x06,
    willtopic = 0x07,
    willmsgreq = 0x08,
    willmsg = 0x09,
    register_ = 0x0A,  // NOLINT(readability-identifier-naming): "register" is a keyword
    regack = 0x0B,
    publish = 0x0C,
    puback = 0x0D,
    pubcomp = 0x0E,
    pubrec = 0x0F,
    pubrel = 0x10,
    subscribe = 0x12,
    suback = 0x13,
    unsubscribe = 0x14,
    unsuback = 0x15,
    pingreq = 0x16,
    pingresp = 0x17,
    disconnect = 0x18,
    willtopicupd = 0x1A,
    willtopicresp = 0x1B,
    willmsgupd = 0x1C,
    willmsgresp = 0x1D,
    encapsulated = 0xFE,
};

enum class TopicId : std::uint16_t {};
enum class MsgId : std::uint16_t {};

inline constexpr TopicId no_topic_id{0x0000};        // reserved, section 5.3.11
inline constexpr TopicId reserved_topic_id{0xFFFF};  // reserved, section 5.3.11
inline constexpr MsgId no_msg_id{0};

/// False for the two reserved ids: never assigned, never accepted in a PUBLISH.
constexpr bool is_assignable(TopicId id) {
    return id != no_topic_id && id != reserved_topic_id;
}

/// How a topic is named in a message; section 5.3.4. The reserved value 0b11 decodes, so that a
/// broker can refuse it with a return code.
enum class TopicIdType : std::uint8_t { normal = 0, predefined = 1, short_name = 2, reserved = 3 };

/// Values as in the flags octet: 0b11 is QoS -1.
enum class Qos : std::uint8_t {
    at_most_once = 0,
    at_least_once = 1,
    exactly_once = 2,
    without_connection = 3,
};

/// Section 5.3.10. Every value is received: "other" codes are a rejection without a name.
enum class ReturnCode : std::uint8_t {
    accepted = 0x00,
    congestion = 0x01,
    invalid_topic_id = 0x02,
    not_supported = 0x03,
};

/// The flags octet, section 5.3.4. Bits that a message does not use are sent as 0 and ignored.
struct Flags {
    bool dup = false;
    Qos qos = Qos::at_most_once;
    bool retain = false;
    bool will = false;
    bool clean_session = false;
    TopicIdType topic_id_type = TopicIdType::normal;

    friend bool operator==(const Flags&, const Flags&) = default;
};

constexpr std::uint8_t to_wire(const Flags& flags) {
    return static_cast<std::uint8_t>(
        (flags.dup ? 0x80U : 0U) | (static_cast<unsigned>(flags.qos) << 5U) |
        (flags.retain ? 0x10U : 0U) | (flags.will ? 0x08U : 0U) |
        (flags.clean_session ? 0x04U : 0U) | static_cast<unsigned>(flags.topic_id_type));
}

constexpr Flags flags_from_wire(std::uint8_t octet) {
    return {.dup = (octet & 0x80U) != 0,
            .qos = static_cast<Qos>((octet >> 5U) & 3U),
            .retain = (octet & 0x10U) != 0,
            .will = (octet & 0x08U) != 0,
            .clean_session = (octet & 0x04U) != 0,
            .topic_id_type = static_cast<TopicIdType>(octet & 3U)};
}

inline constexpr std::uint8_t protocol_id = 0x01;         // section 5.3.8
inline constexpr std::size_t max_datagram = 65507;        // what UDP over IPv4 carries
inline constexpr std::size_t recommended_client_id = 23;  // section 5.3.1

/// Timers and counters as section 7.2 recommends them.
inline constexpr std::chrono::seconds default_t_adv{15 * 60};
inline constexpr std::chrono::seconds default_t_searchgw{5};
inline constexpr std::chrono::seconds default_t_gwinfo{5};
inline constexpr std::chrono::seconds default_t_wait{5 * 60};
inline constexpr std::chrono::seconds default_t_retry{10};
inline constexpr int default_n_retry = 3;
inline constexpr int default_n_adv = 3;

}  // namespace romano::mqttsn
