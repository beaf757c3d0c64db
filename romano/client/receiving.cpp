// MQTT-SN 1.2 sections 6.10 and 6.6 at QoS 2: messages from the broker.
//
// At QoS 2 the message is handed on when it comes first; its message id is remembered until
// PUBREL, and what comes under that id meanwhile is only answered.
#include <algorithm>

#include "romano/client/client.h"

namespace romano::client {

using mqttsn::Qos;
using mqttsn::ReturnCode;
using mqttsn::TopicIdType;

void ClientCore::on_publish(Bytes body, const mqttsn::Publish& message, Output& out) {
    if (!is_receiving()) return drop();
    mqttsn::TopicRef topic{message.topic_type, {}, message.topic};
    if (topic.type == TopicIdType::normal) {
        topic.name = topics_.name_of(message.topic);
        if (topic.name.empty()) return answer_publish(message, ReturnCode::invalid_topic_id, out);
    } else if (topic.type == TopicIdType::short_name) {
        topic.name = as_text(body.subspan(1, 2));  // the octets that the id was read from
    } else if (topic.type == TopicIdType::reserved) {
        return answer_publish(message, ReturnCode::not_supported, out);
    }
    if (message.qos != Qos::exactly_once || remember_unreleased(message.msg_id)) {
        out.tell(Received{topic, message.data, message.qos, message.retain, message.dup});
    }
    if (message.qos == Qos::exactly_once) {
        send(mqttsn::Pubrec{message.msg_id}, out);
    } else if (message.qos == Qos::at_least_once) {
        answer_publish(message, ReturnCode::accepted, out);
    }
}

/// A refusal is told at QoS 0 too (6.6b, 6.10e).
void ClientCore::answer_publish(const mqttsn::Publish& message, ReturnCode code, Output& out) {
    send(mqttsn::Puback{message.topic, message.msg_id, code}, out);
}

/// True when the id is new. When the table is full the oldest goes: a broker has one exchange open
/// per client, so it is one that the broker gave up.
bool ClientCore::remember_unreleased(mqttsn::MsgId msg_id) {
    for (const mqttsn::MsgId known : unreleased_.first(unreleased_count_)) {
        if (known == msg_id) return false;
    }
    if (unreleased_count_ == unreleased_.size()) forget_unreleased(unreleased_[0]);
    unreleased_[unreleased_count_++] = msg_id;
    return true;
}

void ClientCore::forget_unreleased(mqttsn::MsgId msg_id) {
    const auto ids = unreleased_.first(unreleased_count_);
    unreleased_count_ =
        static_cast<std::size_t>(std::remove(ids.begin(), ids.end(), msg_id) - ids.begin());
}

/// Answered also when the id is unknown: PUBCOMP was lost (6.6d).
void ClientCore::on_pubrel(const mqttsn::Pubrel& message, Output& out) {
    if (!is_receiving()) return drop();
    forget_unreleased(message.msg_id);
    send(mqttsn::Pubcomp{message.msg_id}, out);
}

bool ClientCore::is_receiving() const {
    return state_ != State::disconnected && state_ != State::connecting;
}

}  // namespace romano::client
