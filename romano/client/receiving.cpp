// MQTT-SN 1.2 sections 6.10 and 6.6 at QoS 2: messages from the broker.
//
// At QoS 2 the message is handed on when it comes first; its message id is remembered until
// PUBREL, and what comes under that id meanwhile is only answered.
#include "romano/client/client.h"

namespace romano::client {

using mqttsn::MsgType;
using mqttsn::Qos;
using mqttsn::ReturnCode;
using mqttsn::TopicIdType;

/// A refusal is told at QoS 0 too (6.6b, 6.10e).
void ClientCore::on_publish(mqttsn::Body& message, const Call& call) {
    if (!is_receiving()) return drop();
    const TopicIdType type = mqttsn::topic_type_in(message.flags);
    if (hears_cells && type == TopicIdType::reserved) return on_cell_publish(message, call);
    Output& out = call.out;
    std::string_view name;
    if (type == TopicIdType::normal) {
        name = topics_.name_of(message.topic_id);
        if (name.empty()) message.code = ReturnCode::invalid_topic_id;
    } else if (type == TopicIdType::short_name) {
        name = as_text({message.rest.data() - 4, 2});  // the octets that the id was read from
    } else if (type == TopicIdType::reserved) {
        message.code = ReturnCode::not_supported;
    }
    if (message.code != ReturnCode::accepted) return out.send(MsgType::puback, message);
    const Qos qos = mqttsn::qos_in(message.flags);
    if (hears_cells && qos != Qos::at_most_once) last_taken_ = message.msg_id;
    if (qos != Qos::exactly_once || remember_unreleased(message.msg_id)) {
        const mqttsn::Flags flags = mqttsn::flags_from_wire(message.flags);
        out.tell(
            Received{{type, name, message.topic_id}, message.rest, qos, flags.retain, flags.dup});
    }
    if (qos == Qos::exactly_once) out.send(MsgType::pubrec, message);
    if (qos == Qos::at_least_once) out.send(MsgType::puback, message);
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
    std::size_t kept = 0;
    for (const mqttsn::MsgId known : unreleased_.first(unreleased_count_)) {
        if (known != msg_id) unreleased_[kept++] = known;
    }
    unreleased_count_ = kept;
}

/// Answered also when the id is unknown: PUBCOMP was lost (6.6d).
void ClientCore::on_pubrel(const mqttsn::Body& message, Output& out) {
    if (!is_receiving()) return drop();
    forget_unreleased(message.msg_id);
    out.send(MsgType::pubcomp, message);
}

bool ClientCore::is_receiving() const {
    return state_ != State::disconnected && state_ != State::connecting;
}

}  // namespace romano::client
