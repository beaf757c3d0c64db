// Every message has a body_size() and a put(); encode() frames what they say.
#include <cassert>
#include <cstring>
#include <type_traits>
#include <variant>

#include "romano/mqttsn/codec.h"

namespace romano::mqttsn {
namespace {

/// Writes fields one after the other. The room was checked when the frame was begun.
class Fields {
public:
    explicit Fields(std::uint8_t* at) : at_(at) {}

    Fields& u8(std::uint8_t value) {
        *at_++ = value;
        return *this;
    }
    Fields& u16(std::uint16_t value) {
        at_[0] = static_cast<std::uint8_t>(value >> 8U);
        at_[1] = static_cast<std::uint8_t>(value & 0xFFU);
        at_ += 2;
        return *this;
    }
    Fields& id(TopicId value) { return u16(static_cast<std::uint16_t>(value)); }
    Fields& id(MsgId value) { return u16(static_cast<std::uint16_t>(value)); }
    Fields& code(ReturnCode value) { return u8(static_cast<std::uint8_t>(value)); }
    Fields& flags(const Flags& value) { return u8(to_wire(value)); }
    Fields& octets(Bytes value) {
        if (!value.empty()) std::memcpy(at_, value.data(), value.size());
        at_ += value.size();
        return *this;
    }
    Fields& text(std::string_view value) { return octets(as_octets(value)); }
    Fields& topic(const TopicRef& value) {
        return value.type == TopicIdType::predefined ? id(value.id) : text(value.name);
    }

private:
    std::uint8_t* at_;
};

std::size_t size_of(const TopicRef& topic) {
    assert(topic.type != TopicIdType::short_name || topic.name.size() <= 2);
    return topic.type == TopicIdType::predefined ? 2 : topic.name.size();
}

/// An empty will topic has no flags either.
std::size_t will_topic_size(std::string_view topic) {
    return topic.empty() ? 0 : 1 + topic.size();
}

void put_will_topic(Fields to, Qos qos, bool retain, std::string_view topic) {
    if (topic.empty()) return;
    to.flags({.qos = qos, .retain = retain}).text(topic);
}

std::size_t body_size(const Advertise&) {
    return 3;
}
void put(const Advertise& m, Fields to) {
    to.u8(m.gateway_id).u16(m.duration_s);
}

std::size_t body_size(const Searchgw&) {
    return 1;
}
void put(const Searchgw& m, Fields to) {
    to.u8(m.radius);
}

std::size_t body_size(const Gwinfo& m) {
    return 1 + m.gateway_address.size();
}
void put(const Gwinfo& m, Fields to) {
    to.u8(m.gateway_id).octets(m.gateway_address);
}

std::size_t body_size(const Connect& m) {
    return 4 + m.client_id.size();
}
void put(const Connect& m, Fields to) {
    to.flags({.will = m.will, .clean_session = m.clean_session})
        .u8(m.protocol_id)
        .u16(m.duration_s)
        .text(m.client_id);
}

std::size_t body_size(const Connack&) {
    return 1;
}
void put(const Connack& m, Fields to) {
    to.code(m.return_code);
}

std::size_t body_size(const Willtopicreq&) {
    return 0;
}
void put(const Willtopicreq&, Fields) {}

std::size_t body_size(const Willtopic& m) {
    return will_topic_size(m.topic);
}
void put(const Willtopic& m, Fields to) {
    put_will_topic(to, m.qos, m.retain, m.topic);
}

std::size_t body_size(const Willmsgreq&) {
    return 0;
}
void put(const Willmsgreq&, Fields) {}

std::size_t body_size(const Willmsg& m) {
    return m.message.size();
}
void put(const Willmsg& m, Fields to) {
    to.octets(m.message);
}

std::size_t body_size(const Register& m) {
    return 4 + m.topic_name.size();
}
void put(const Register& m, Fields to) {
    to.id(m.topic_id).id(m.msg_id).text(m.topic_name);
}

std::size_t body_size(const Regack&) {
    return 5;
}
void put(const Regack& m, Fields to) {
    to.id(m.topic_id).id(m.msg_id).code(m.return_code);
}

std::size_t body_size(const Publish& m) {
    return 5 + m.data.size();
}
void put(const Publish& m, Fields to) {
    to.flags({.dup = m.dup, .qos = m.qos, .retain = m.retain, .topic_id_type = m.topic_type})
        .id(m.topic)
        .id(m.msg_id)
        .octets(m.data);
}

std::size_t body_size(const Puback&) {
    return 5;
}
void put(const Puback& m, Fields to) {
    to.id(m.topic_id).id(m.msg_id).code(m.return_code);
}

std::size_t body_size(const Pubcomp&) {
    return 2;
}
void put(const Pubcomp& m, Fields to) {
    to.id(m.msg_id);
}

std::size_t body_size(const Pubrec&) {
    return 2;
}
void put(const Pubrec& m, Fields to) {
    to.id(m.msg_id);
}

std::size_t body_size(const Pubrel&) {
    return 2;
}
void put(const Pubrel& m, Fields to) {
    to.id(m.msg_id);
}

std::size_t body_size(const Subscribe& m) {
    return 3 + size_of(m.topic);
}
void put(const Subscribe& m, Fields to) {
    to.flags({.dup = m.dup, .qos = m.qos, .topic_id_type = m.topic.type})
        .id(m.msg_id)
        .topic(m.topic);
}

std::size_t body_size(const Suback&) {
    return 6;
}
void put(const Suback& m, Fields to) {
    to.flags({.qos = m.qos}).id(m.topic_id).id(m.msg_id).code(m.return_code);
}

std::size_t body_size(const Unsubscribe& m) {
    return 3 + size_of(m.topic);
}
void put(const Unsubscribe& m, Fields to) {
    to.flags({.topic_id_type = m.topic.type}).id(m.msg_id).topic(m.topic);
}

std::size_t body_size(const Unsuback&) {
    return 2;
}
void put(const Unsuback& m, Fields to) {
    to.id(m.msg_id);
}

std::size_t body_size(const Pingreq& m) {
    return m.client_id.size();
}
void put(const Pingreq& m, Fields to) {
    to.text(m.client_id);
}

std::size_t body_size(const Pingresp&) {
    return 0;
}
void put(const Pingresp&, Fields) {}

std::size_t body_size(const Disconnect& m) {
    return m.has_duration ? 2 : 0;
}
void put(const Disconnect& m, Fields to) {
    if (m.has_duration) to.u16(m.duration_s);
}

std::size_t body_size(const Willtopicupd& m) {
    return will_topic_size(m.topic);
}
void put(const Willtopicupd& m, Fields to) {
    put_will_topic(to, m.qos, m.retain, m.topic);
}

std::size_t body_size(const Willtopicresp&) {
    return 1;
}
void put(const Willtopicresp& m, Fields to) {
    to.code(m.return_code);
}

std::size_t body_size(const Willmsgupd& m) {
    return m.message.size();
}
void put(const Willmsgupd& m, Fields to) {
    to.octets(m.message);
}

std::size_t body_size(const Willmsgresp&) {
    return 1;
}
void put(const Willmsgresp& m, Fields to) {
    to.code(m.return_code);
}

template <typename M>
std::size_t encode_framed(const M& message, MutableBytes out) {
    const std::size_t body = body_size(message);
    std::uint8_t* at = begin_frame(M::type, body, out);
    if (at == nullptr) return 0;
    put(message, Fields{at});
    return framed_size(body);
}

}  // namespace

std::size_t encode(const Advertise& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Searchgw& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Gwinfo& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Connect& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Connack& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Willtopicreq& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Willtopic& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Willmsgreq& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Willmsg& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Register& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Regack& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Publish& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Puback& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Pubcomp& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Pubrec& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Pubrel& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Subscribe& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Suback& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Unsubscribe& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Unsuback& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Pingreq& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Pingresp& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Disconnect& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Willtopicupd& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Willtopicresp& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Willmsgupd& m, MutableBytes out) {
    return encode_framed(m, out);
}
std::size_t encode(const Willmsgresp& m, MutableBytes out) {
    return encode_framed(m, out);
}

/// Section 5.5: the length octet counts the forwarder's header only.
std::size_t encode(const Encapsulated& m, MutableBytes out) {
    const std::size_t header = 3 + m.wireless_node_id.size();
    if (header > 255 || header + m.message.size() > out.size()) return 0;
    Fields{out.data()}
        .u8(static_cast<std::uint8_t>(header))
        .u8(static_cast<std::uint8_t>(MsgType::encapsulated))
        .u8(m.radius & 3U)
        .octets(m.wireless_node_id)
        .octets(m.message);
    return header + m.message.size();
}

std::size_t encode(const Message& message, MutableBytes out) {
    return std::visit([out](const auto& m) { return encode(m, out); }, message);
}

std::size_t encoded_size(const Publish& message) {
    return framed_size(body_size(message));
}

std::size_t encoded_size(const Message& message) {
    return std::visit(
        [](const auto& m) -> std::size_t {
            if constexpr (std::is_same_v<decltype(m), const Encapsulated&>) {
                return 3 + m.wireless_node_id.size() + m.message.size();
            } else {
                return framed_size(body_size(m));
            }
        },
        message);
}

}  // namespace romano::mqttsn
