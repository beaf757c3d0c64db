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
    std::uint8_t gateway_id;
    std::uint16_t duration_s;
};
struct Searchgw {
    std::uint8_t radius;
};
struct Gwinfo {
    std::uint8_t gateway_id;
    Bytes gateway_address;  // empty when a gateway sends it
};

/// Section 5.4.4. The protocol id is kept as received: a wrong one is refused by CONNACK.
struct Connect {
    bool will;
    bool clean_session;
    std::uint8_t protocol_id;
    std::uint16_t duration_s;    // keep-alive; 0 means no supervision
    std::string_view client_id;  // may be empty (some clients' default)
};
struct Connack {
    ReturnCode return_code;
};

/// Sections 5.4.6 to 5.4.9: the will prompts. An empty topic deletes the will (both wire forms).
struct Willtopicreq {};
struct Willtopic {
    Qos qos;
    bool retain;
    std::string_view topic;
};
struct Willmsgreq {};
struct Willmsg {
    Bytes message;
};

/// Sections 5.4.10 and 5.4.11. A client sends topic id 0.
struct Register {
    TopicId topic_id;
    MsgId msg_id;
    std::string_view topic_name;
};
struct Regack {
    TopicId topic_id;
    MsgId msg_id;
    ReturnCode return_code;
};

/// Section 5.4.12. `topic` holds the two octets as they stand: an id, or a short name's characters
/// (first character in the high octet); `topic_type` says which.
struct Publish {
    bool dup;
    Qos qos;
    bool retain;
    TopicIdType topic_type;
    TopicId topic;
    MsgId msg_id;
    Bytes data;
};
struct Puback {
    TopicId topic_id;
    MsgId msg_id;
    ReturnCode return_code;
};
struct Pubcomp {
    MsgId msg_id;
};
struct Pubrec {
    MsgId msg_id;
};
struct Pubrel {
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
    bool dup;
    Qos qos;
    MsgId msg_id;
    TopicRef topic;
};
struct Suback {
    Qos qos;  // granted
    TopicId topic_id;
    MsgId msg_id;
    ReturnCode return_code;
};
struct Unsubscribe {
    MsgId msg_id;
    TopicRef topic;
};
struct Unsuback {
    MsgId msg_id;
};

/// Sections 5.4.19 to 5.4.21.
struct Pingreq {
    std::string_view client_id;  // empty unless a sleeping client asks for its messages
};
struct Pingresp {};
struct Disconnect {
    bool has_duration;
    std::uint16_t duration_s;  // sleep duration when has_duration
};

/// Sections 5.4.22 to 5.4.25: will updates. An empty topic deletes the will.
struct Willtopicupd {
    Qos qos;
    bool retain;
    std::string_view topic;
};
struct Willtopicresp {
    ReturnCode return_code;
};
struct Willmsgupd {
    Bytes message;
};
struct Willmsgresp {
    ReturnCode return_code;
};

/// Section 5.5. `message` is the whole message behind the forwarder's header, not yet decoded.
struct Encapsulated {
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
