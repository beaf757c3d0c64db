// One struct a message of MQTT-SN 1.2, field by field as in section 5.4.
//
// Texts and octets are views: after decoding they point into the datagram and live as long as it
// does. A topic that a message names by its flags' TopicIdType is a TopicRef.
#pragma once

#include <cstdint>
#include <string_view>
#include <variant>

#include "romano/base/bytes.h"
#include "romano/mqttsn/types.h"

namespace romano::mqttsn {

/// Sections 5.4.1 to 5.4.3: discovery.
struct Advertise {
    static constexpr MsgType type = MsgType::advertise;
    std::uint8_t gateway_id;
    std::uint16_t duration_s;
};
struct Searchgw {
    static constexpr MsgType type = MsgType::searchgw;
    std::uint8_t radius;
};
struct Gwinfo {
    static constexpr MsgType type = MsgType::gwinfo;
    std::uint8_t gateway_id;
    Bytes gateway_address;  // empty when a gateway sends it
};

/// Section 5.4.4. The protocol id is kept as received: a wrong one is refused by CONNACK.
struct Connect {
    static constexpr MsgType type = MsgType::connect;
    bool will;
    bool clean_session;
    std::uint8_t protocol_id;
    std::uint16_t duration_s;    // keep-alive; 0 means no supervision
    std::string_view client_id;  // may be empty (some clients' default)
};
struct Connack {
    static constexpr MsgType type = MsgType::connack;
    ReturnCode return_code;
};

/// Sections 5.4.6 to 5.4.9: the will prompts. An empty topic deletes the will (both wire forms).
struct Willtopicreq {
    static constexpr MsgType type = MsgType::willtopicreq;
};
struct Willtopic {
    static constexpr MsgType type = MsgType::willtopic;
    Qos qos;
    bool retain;
    std::string_view topic;
};
struct Willmsgreq {
    static constexpr MsgType type = MsgType::willmsgreq;
};
struct Willmsg {
    static constexpr MsgType type = MsgType::willmsg;
    Bytes message;
};

/// Sections 5.4.10 and 5.4.11. A client sends topic id 0.
struct Register {
    static constexpr MsgType type = MsgType::register_;
    TopicId topic_id;
    MsgId msg_id;
    std::string_view topic_name;
};
struct Regack {
    static constexpr MsgType type = MsgType::regack;
    TopicId topic_id;
    MsgId msg_id;
    ReturnCode return_code;
};

/// Section 5.4.12. `topic` holds the two octets as they stand: an id, or a short name's characters
/// (first character in the high octet); `topic_type` says which.
struct Publish {
    static constexpr MsgType type = MsgType::publish;
    bool dup;
    Qos qos;
    bool retain;
    TopicIdType topic_type;
    TopicId topic;
    MsgId msg_id;
    Bytes data;
};
struct Puback {
    static constexpr MsgType type = MsgType::puback;
    TopicId topic_id;
    MsgId msg_id;
    ReturnCode return_code;
};
struct Pubcomp {
    static constexpr MsgType type = MsgType::pubcomp;
    MsgId msg_id;
};
struct Pubrec {
    static constexpr MsgType type = MsgType::pubrec;
    MsgId msg_id;
};
struct Pubrel {
    static constexpr MsgType type = MsgType::pubrel;
    MsgId msg_id;
};

/// The topic of SUBSCRIBE and UNSUBSCRIBE: a name (type normal; also a short name, with its one or
/// two octets) or a predefined id.
struct TopicRef {
    TopicIdType type;
    std::string_view name;  // normal and short_name
    TopicId id;             // predefined
};
struct Subscribe {
    static constexpr MsgType type = MsgType::subscribe;
    bool dup;
    Qos qos;
    MsgId msg_id;
    TopicRef topic;
};
struct Suback {
    static constexpr MsgType type = MsgType::suback;
    Qos qos;  // granted
    TopicId topic_id;
    MsgId msg_id;
    ReturnCode return_code;
};
struct Unsubscribe {
    static constexpr MsgType type = MsgType::unsubscribe;
    MsgId msg_id;
    TopicRef topic;
};
struct Unsuback {
    static constexpr MsgType type = MsgType::unsuback;
    MsgId msg_id;
};

/// Sections 5.4.19 to 5.4.21.
struct Pingreq {
    static constexpr MsgType type = MsgType::pingreq;
    std::string_view client_id;  // empty unless a sleeping client asks for its messages
};
struct Pingresp {
    static constexpr MsgType type = MsgType::pingresp;
};
struct Disconnect {
    static constexpr MsgType type = MsgType::disconnect;
    bool has_duration;
    std::uint16_t duration_s;  // sleep duration when has_duration
};

/// Sections 5.4.22 to 5.4.25: will updates. An empty topic deletes the will.
struct Willtopicupd {
    static constexpr MsgType type = MsgType::willtopicupd;
    Qos qos;
    bool retain;
    std::string_view topic;
};
struct Willtopicresp {
    static constexpr MsgType type = MsgType::willtopicresp;
    ReturnCode return_code;
};
struct Willmsgupd {
    static constexpr MsgType type = MsgType::willmsgupd;
    Bytes message;
};
struct Willmsgresp {
    static constexpr MsgType type = MsgType::willmsgresp;
    ReturnCode return_code;
};

/// Section 5.5. `message` is the whole message behind the forwarder's header, not yet decoded.
struct Encapsulated {
    static constexpr MsgType type = MsgType::encapsulated;
    std::uint8_t radius;
    Bytes wireless_node_id;
    Bytes message;
};

using Message =
    std::variant<Advertise, Searchgw, Gwinfo, Connect, Connack, Willtopicreq, Willtopic, Willmsgreq,
                 Willmsg, Register, Regack, Publish, Puback, Pubcomp, Pubrec, Pubrel, Subscribe,
                 Suback, Unsubscribe, Unsuback, Pingreq, Pingresp, Disconnect, Willtopicupd,
                 Willtopicresp, Willmsgupd, Willmsgresp, Encapsulated>;

}  // namespace romano::mqttsn
