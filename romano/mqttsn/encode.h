// One encoder a message: the body behind the frame, MQTT-SN 1.2 section 5.4, field by field.
//
// For senders that make the frame themselves: begin_frame() with body_size(), then put(). encode()
// in codec.h does both.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "romano/base/bytes.h"
#include "romano/mqttsn/messages.h"
#include "romano/mqttsn/types.h"

namespace romano::mqttsn {

/// Writes fields one after the other; each call returns where the next belongs. The room was
/// checked when the frame was begun.
class Fields {
public:
    explicit Fields(std::uint8_t* at) : at_(at) {}

    Fields u8(std::uint8_t value) const {
        *at_ = value;
        return Fields{at_ + 1};
    }
    Fields u16(std::uint16_t value) const {
        at_[0] = static_cast<std::uint8_t>(value >> 8U);
        at_[1] = static_cast<std::uint8_t>(value & 0xFFU);
        return Fields{at_ + 2};
    }
    Fields id(TopicId value) const { return u16(static_cast<std::uint16_t>(value)); }
    Fields id(MsgId value) const { return u16(static_cast<std::uint16_t>(value)); }
    Fields code(ReturnCode value) const { return u8(static_cast<std::uint8_t>(value)); }
    Fields flags(const Flags& value) const { return u8(to_wire(value)); }
    Fields octets(Bytes value) const {
        if (!value.empty()) std::memcpy(at_, value.data(), value.size());
        return Fields{at_ + value.size()};
    }
    Fields text(std::string_view value) const { return octets(as_octets(value)); }
    Fields topic(const TopicRef& value) const {
        return value.type == TopicIdType::predefined ? id(value.id) : text(value.name);
    }

private:
    std::uint8_t* at_;
};

inline std::size_t size_of(const TopicRef& topic) {
    assert(topic.type != TopicIdType::short_name || topic.name.size() <= 2);
    return topic.type == TopicIdType::predefined ? 2 : topic.name.size();
}

/// An empty will topic has no flags either.
inline std::size_t will_topic_size(std::string_view topic) {
    return topic.empty() ? 0 : 1 + topic.size();
}

inline void put_will_topic(Fields to, Qos qos, bool retain, std::string_view topic) {
    if (topic.empty()) return;
    to.flags({.qos = qos, .retain = retain}).text(topic);
}

inline std::size_t body_size(const Advertise&) {
    return 3;
}
inline void put(const Advertise& m, Fields to) {
    to.u8(m.gateway_id).u16(m.duration_s);
}

inline std::size_t body_size(const Searchgw&) {
    return 1;
}
inline void put(const Searchgw& m, Fields to) {
    to.u8(m.radius);
}

inline std::size_t body_size(const Gwinfo& m) {
    return 1 + m.gateway_address.size();
}
inline void put(const Gwinfo& m, Fields to) {
    to.u8(m.gateway_id).octets(m.gateway_address);
}

inline std::size_t body_size(const Connect& m) {
    return 4 + m.client_id.size();
}
inline void put(const Connect& m, Fields to) {
    to.flags({.will = m.will, .clean_session = m.clean_session})
        .u8(m.protocol_id)
        .u16(m.duration_s)
        .text(m.client_id);
}

inline std::size_t body_size(const Connack&) {
    return 1;
}
inline void put(const Connack& m, Fields to) {
    to.code(m.return_code);
}

inline std::size_t body_size(const Willtopicreq&) {
    return 0;
}
inline void put(const Willtopicreq&, Fields) {}

inline std::size_t body_size(const Willtopic& m) {
    return will_topic_size(m.topic);
}
inline void put(const Willtopic& m, Fields to) {
    put_will_topic(to, m.qos, m.retain, m.topic);
}

inline std::size_t body_size(const Willmsgreq&) {
    return 0;
}
inline void put(const Willmsgreq&, Fields) {}

inline std::size_t body_size(const Willmsg& m) {
    return m.message.size();
}
inline void put(const Willmsg& m, Fields to) {
    to.octets(m.message);
}

inline std::size_t body_size(const Register& m) {
    return 4 + m.topic_name.size();
}
inline void put(const Register& m, Fields to) {
    to.id(m.topic_id).id(m.msg_id).text(m.topic_name);
}

inline std::size_t body_size(const Regack&) {
    return 5;
}
inline void put(const Regack& m, Fields to) {
    to.id(m.topic_id).id(m.msg_id).code(m.return_code);
}

inline std::size_t body_size(const Publish& m) {
    return 5 + m.data.size();
}
inline void put(const Publish& m, Fields to) {
    to.flags({.dup = m.dup, .qos = m.qos, .retain = m.retain, .topic_id_type = m.topic_type})
        .id(m.topic)
        .id(m.msg_id)
        .octets(m.data);
}

inline std::size_t body_size(const Puback&) {
    return 5;
}
inline void put(const Puback& m, Fields to) {
    to.id(m.topic_id).id(m.msg_id).code(m.return_code);
}

inline std::size_t body_size(const Pubcomp&) {
    return 2;
}
inline void put(const Pubcomp& m, Fields to) {
    to.id(m.msg_id);
}

inline std::size_t body_size(const Pubrec&) {
    return 2;
}
inline void put(const Pubrec& m, Fields to) {
    to.id(m.msg_id);
}

inline std::size_t body_size(const Pubrel&) {
    return 2;
}
inline void put(const Pubrel& m, Fields to) {
    to.id(m.msg_id);
}

inline std::size_t body_size(const Subscribe& m) {
    return 3 + size_of(m.topic);
}
inline void put(const Subscribe& m, Fields to) {
    to.flags({.dup = m.dup, .qos = m.qos, .topic_id_type = m.topic.type})
        .id(m.msg_id)
        .topic(m.topic);
}

inline std::size_t body_size(const Suback&) {
    return 6;
}
inline void put(const Suback& m, Fields to) {
    to.flags({.qos = m.qos}).id(m.topic_id).id(m.msg_id).code(m.return_code);
}

inline std::size_t body_size(const Unsubscribe& m) {
    return 3 + size_of(m.topic);
}
inline void put(const Unsubscribe& m, Fields to) {
    to.flags({.topic_id_type = m.topic.type}).id(m.msg_id).topic(m.topic);
}

inline std::size_t body_size(const Unsuback&) {
    return 2;
}
inline void put(const Unsuback& m, Fields to) {
    to.id(m.msg_id);
}

inline std::size_t body_size(const Pingreq& m) {
    return m.client_id.size();
}
inline void put(const Pingreq& m, Fields to) {
    to.text(m.client_id);
}

inline std::size_t body_size(const Pingresp&) {
    return 0;
}
inline void put(const Pingresp&, Fields) {}

inline std::size_t body_size(const Disconnect& m) {
    return m.has_duration ? 2 : 0;
}
inline void put(const Disconnect& m, Fields to) {
    if (m.has_duration) to.u16(m.duration_s);
}

inline std::size_t body_size(const Willtopicupd& m) {
    return will_topic_size(m.topic);
}
inline void put(const Willtopicupd& m, Fields to) {
    put_will_topic(to, m.qos, m.retain, m.topic);
}

inline std::size_t body_size(const Willtopicresp&) {
    return 1;
}
inline void put(const Willtopicresp& m, Fields to) {
    to.code(m.return_code);
}

inline std::size_t body_size(const Willmsgupd& m) {
    return m.message.size();
}
inline void put(const Willmsgupd& m, Fields to) {
    to.octets(m.message);
}

inline std::size_t body_size(const Willmsgresp&) {
    return 1;
}
inline void put(const Willmsgresp& m, Fields to) {
    to.code(m.return_code);
}

}  // namespace romano::mqttsn
