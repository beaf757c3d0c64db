#include "romano/mqttsn/decode.h"

#include "romano/mqttsn/codec.h"

namespace romano::mqttsn {
namespace {

TopicId topic_id_at(Bytes body, std::size_t at) {
    return TopicId{be16(body, at)};
}
MsgId msg_id_at(Bytes body, std::size_t at) {
    return MsgId{be16(body, at)};
}
ReturnCode return_code_at(Bytes body, std::size_t at) {
    return ReturnCode{body[at]};
}

template <typename M>
Decoded<M> without_fields(Bytes body) {
    if (!body.empty()) return Malformed::size;
    return M{};
}

template <typename M>
Decoded<M> only_return_code(Bytes body) {
    if (body.size() != 1) return Malformed::size;
    return M{return_code_at(body, 0)};
}

template <typename M>
Decoded<M> only_msg_id(Bytes body) {
    if (body.size() != 2) return Malformed::size;
    return M{msg_id_at(body, 0)};
}

template <typename M>
Decoded<M> topic_id_msg_id_return_code(Bytes body) {
    if (body.size() != 5) return Malformed::size;
    return M{topic_id_at(body, 0), msg_id_at(body, 2), return_code_at(body, 4)};
}

/// Flags and topic, or neither: the empty form. Flags without a topic mean the same (6.3a).
template <typename M>
Decoded<M> will_topic(Bytes body) {
    if (body.empty()) return M{Qos::at_most_once, false, {}};
    const Flags flags = flags_from_wire(body[0]);
    return M{flags.qos, flags.retain, as_text(body.subspan(1))};
}

/// The last field of SUBSCRIBE and UNSUBSCRIBE. A short name may have a single octet (G18). What
/// stands behind the reserved type cannot be known; it is kept as text so that the request can be
/// refused with a return code.
Decoded<TopicRef> topic_ref(TopicIdType type, Bytes field) {
    if (field.empty()) return Malformed::size;
    if (type == TopicIdType::predefined) {
        if (field.size() != 2) return Malformed::size;
        return TopicRef{type, {}, topic_id_at(field, 0)};
    }
    if (type == TopicIdType::short_name && field.size() > 2) return Malformed::size;
    return TopicRef{type, as_text(field), no_topic_id};
}

template <typename M>
Decoded<Message> as_message(const Decoded<M>& decoded) {
    if (!decoded) return decoded.error();
    return Message{*decoded};
}

}  // namespace

Decoded<Advertise> decode_advertise(Bytes body) {
    if (body.size() != 3) return Malformed::size;
    return Advertise{body[0], be16(body, 1)};
}

Decoded<Searchgw> decode_searchgw(Bytes body) {
    if (body.size() != 1) return Malformed::size;
    return Searchgw{body[0]};
}

Decoded<Gwinfo> decode_gwinfo(Bytes body) {
    if (body.empty()) return Malformed::size;
    return Gwinfo{body[0], body.subspan(1)};
}

Decoded<Connect> decode_connect(Bytes body) {
    if (body.size() < 4) return Malformed::size;
    const Flags flags = flags_from_wire(body[0]);
    return Connect{flags.will, flags.clean_session, body[1], be16(body, 2),
                   as_text(body.subspan(4))};
}

Decoded<Connack> decode_connack(Bytes body) {
    return only_return_code<Connack>(body);
}

Decoded<Willtopicreq> decode_willtopicreq(Bytes body) {
    return without_fields<Willtopicreq>(body);
}

Decoded<Willtopic> decode_willtopic(Bytes body) {
    return will_topic<Willtopic>(body);
}

Decoded<Willmsgreq> decode_willmsgreq(Bytes body) {
    return without_fields<Willmsgreq>(body);
}

Decoded<Willmsg> decode_willmsg(Bytes body) {
    return Willmsg{body};
}

/// An empty name decodes: it is refused with a return code (6.5b).
Decoded<Register> decode_register(Bytes body) {
    if (body.size() < 4) return Malformed::size;
    return Register{topic_id_at(body, 0), msg_id_at(body, 2), as_text(body.subspan(4))};
}

Decoded<Regack> decode_regack(Bytes body) {
    return topic_id_msg_id_return_code<Regack>(body);
}

Decoded<Publish> decode_publish(Bytes body) {
    if (body.size() < 5) return Malformed::size;
    const Flags flags = flags_from_wire(body[0]);
    return Publish{
        flags.dup,          flags.qos,      flags.retain, flags.topic_id_type, topic_id_at(body, 1),
        msg_id_at(body, 3), body.subspan(5)};
}

Decoded<Puback> decode_puback(Bytes body) {
    return topic_id_msg_id_return_code<Puback>(body);
}

Decoded<Pubcomp> decode_pubcomp(Bytes body) {
    return only_msg_id<Pubcomp>(body);
}

Decoded<Pubrec> decode_pubrec(Bytes body) {
    return only_msg_id<Pubrec>(body);
}

Decoded<Pubrel> decode_pubrel(Bytes body) {
    return only_msg_id<Pubrel>(body);
}

Decoded<Subscribe> decode_subscribe(Bytes body) {
    if (body.size() < 3) return Malformed::size;
    const Flags flags = flags_from_wire(body[0]);
    const auto topic = topic_ref(flags.topic_id_type, body.subspan(3));
    if (!topic) return topic.error();
    return Subscribe{flags.dup, flags.qos, msg_id_at(body, 1), *topic};
}

Decoded<Suback> decode_suback(Bytes body) {
    if (body.size() != 6) return Malformed::size;
    const Flags flags = flags_from_wire(body[0]);
    return Suback{flags.qos, topic_id_at(body, 1), msg_id_at(body, 3), return_code_at(body, 5)};
}

Decoded<Unsubscribe> decode_unsubscribe(Bytes body) {
    if (body.size() < 3) return Malformed::size;
    const auto topic = topic_ref(flags_from_wire(body[0]).topic_id_type, body.subspan(3));
    if (!topic) return topic.error();
    return Unsubscribe{msg_id_at(body, 1), *topic};
}

Decoded<Unsuback> decode_unsuback(Bytes body) {
    return only_msg_id<Unsuback>(body);
}

Decoded<Pingreq> decode_pingreq(Bytes body) {
    return Pingreq{as_text(body)};
}

Decoded<Pingresp> decode_pingresp(Bytes body) {
    return without_fields<Pingresp>(body);
}

Decoded<Disconnect> decode_disconnect(Bytes body) {
    if (body.empty()) return Disconnect{false, 0};
    if (body.size() != 2) return Malformed::size;
    return Disconnect{true, be16(body, 0)};
}

Decoded<Willtopicupd> decode_willtopicupd(Bytes body) {
    return will_topic<Willtopicupd>(body);
}

Decoded<Willtopicresp> decode_willtopicresp(Bytes body) {
    return only_return_code<Willtopicresp>(body);
}

Decoded<Willmsgupd> decode_willmsgupd(Bytes body) {
    return Willmsgupd{body};
}

Decoded<Willmsgresp> decode_willmsgresp(Bytes body) {
    return only_return_code<Willmsgresp>(body);
}

/// A node id has at least one octet, and a wrapped message is not itself wrapped (5.5c).
Decoded<Encapsulated> decode_encapsulated(const Frame& frame) {
    if (frame.body.size() < 2 || frame.wrapped.size() < 2) return Malformed::size;
    const bool wrapped_again = frame.wrapped[0] != 0x01 &&
                               frame.wrapped[1] == static_cast<std::uint8_t>(MsgType::encapsulated);
    if (wrapped_again) return Malformed::reserved_value;
    return Encapsulated{static_cast<std::uint8_t>(frame.body[0] & 3U), frame.body.subspan(1),
                        frame.wrapped};
}

Decoded<Message> decode(Bytes datagram) {
    const auto frame = decode_frame(datagram);
    if (!frame) return frame.error();
    const Bytes body = frame->body;
    switch (frame->type) {
        case MsgType::publish:
            return as_message(decode_publish(body));
        case MsgType::puback:
            return as_message(decode_puback(body));
        case MsgType::pubrec:
            return as_message(decode_pubrec(body));
        case MsgType::pubrel:
            return as_message(decode_pubrel(body));
        case MsgType::pubcomp:
            return as_message(decode_pubcomp(body));
        case MsgType::advertise:
            return as_message(decode_advertise(body));
        case MsgType::searchgw:
            return as_message(decode_searchgw(body));
        case MsgType::gwinfo:
            return as_message(decode_gwinfo(body));
        case MsgType::connect:
            return as_message(decode_connect(body));
        case MsgType::connack:
            return as_message(decode_connack(body));
        case MsgType::willtopicreq:
            return as_message(decode_willtopicreq(body));
        case MsgType::willtopic:
            return as_message(decode_willtopic(body));
        case MsgType::willmsgreq:
            return as_message(decode_willmsgreq(body));
        case MsgType::willmsg:
            return as_message(decode_willmsg(body));
        case MsgType::register_:
            return as_message(decode_register(body));
        case MsgType::regack:
            return as_message(decode_regack(body));
        case MsgType::subscribe:
            return as_message(decode_subscribe(body));
        case MsgType::suback:
            return as_message(decode_suback(body));
        case MsgType::unsubscribe:
            return as_message(decode_unsubscribe(body));
        case MsgType::unsuback:
            return as_message(decode_unsuback(body));
        case MsgType::pingreq:
            return as_message(decode_pingreq(body));
        case MsgType::pingresp:
            return as_message(decode_pingresp(body));
        case MsgType::disconnect:
            return as_message(decode_disconnect(body));
        case MsgType::willtopicupd:
            return as_message(decode_willtopicupd(body));
        case MsgType::willtopicresp:
            return as_message(decode_willtopicresp(body));
        case MsgType::willmsgupd:
            return as_message(decode_willmsgupd(body));
        case MsgType::willmsgresp:
            return as_message(decode_willmsgresp(body));
        case MsgType::encapsulated:
            return as_message(decode_encapsulated(*frame));
    }
    return Malformed::reserved_type;
}

}  // namespace romano::mqttsn
