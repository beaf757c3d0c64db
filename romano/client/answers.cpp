// The broker's answers to the operation at the front: MQTT-SN 1.2 sections 6.4, 6.5, 6.6, 6.9.
#include "romano/client/client.h"
#include "romano/mqttsn/cell.h"

namespace romano::client {

using mqttsn::Body;
using mqttsn::MsgType;
using mqttsn::Qos;
using mqttsn::ReturnCode;
using mqttsn::TopicIdType;

bool ClientCore::is_awaited(MsgType answer, mqttsn::MsgId msg_id) const {
    const Operation& operation = operations_.front();
    if (state_ != State::connected || !exchange_.is_running() || operations_.empty() ||
        operation.msg_id != msg_id) {
        return false;
    }
    if (answer == MsgType::pubcomp) return operation.sent == MsgType::pubrel;
    if (answer == MsgType::pubrec) {  // asks for PUBREL however often it comes
        return operation.request == MsgType::publish && operation.qos() == Qos::exactly_once &&
               operation.sent != MsgType::register_;
    }
    // The numbers of the others are those of their requests plus one (5.2.2).
    return static_cast<unsigned>(answer) == static_cast<unsigned>(operation.sent) + 1;
}

/// "Congestion" is no end: the same is asked again after T_WAIT.
void ClientCore::on_answer(MsgType type, const Body& message, const Call& call) {
    Operation& operation = operations_.front();
    const ReturnCode code = message.code;
    if (!is_awaited(type, message.msg_id)) {
        return type == MsgType::puback ? on_puback_of_qos0(message, call) : drop();
    }
    if (type == MsgType::puback) {
        if (code == ReturnCode::accepted && operation.qos() == Qos::exactly_once) {
            return drop();  // never belongs to QoS 2 (6.6a)
        }
        if (code == ReturnCode::invalid_topic_id && !operation.registered_anew &&
            operation.topic_type() == TopicIdType::normal) {
            on_sign_of_life(call.now);
            topics_.forget(operation.topic_id);
            operation.registered_anew = true;
            return postpone_front();
        }
    }
    on_sign_of_life(call.now);
    if (code == ReturnCode::accepted) return on_acceptance(type, message, call);
    if (code != ReturnCode::congestion) return fail_front(code, call.out);
    postpone_front();
    pause(call);
}

void ClientCore::on_acceptance(MsgType type, const Body& message, const Call& call) {
    const Operation& operation = operations_.front();
    if (type == MsgType::pubrec) return send_first(MsgType::pubrel, message.msg_id, call);
    const bool has_id = mqttsn::is_assignable(message.topic_id);
    if (type == MsgType::regack && !has_id) {
        return fail_front(ReturnCode::invalid_topic_id, call.out);
    }
    const bool learns = type == MsgType::regack || type == MsgType::suback;
    if (learns && has_id && operation.topic_type() == TopicIdType::normal &&
        !topics_.put(message.topic_id, operations_.front_name(),
                     TopicTable::Use{type == MsgType::regack})) {
        return fail_front(ReturnCode::congestion, call.out);
    }
    switch (operation.request) {
        case MsgType::register_:
            return finish_front(Registered{operation.id, message.topic_id}, call.out);
        case MsgType::subscribe:
            if (hears_cells && operations_.front_name() == mqttsn::cell_topic) listens_ = true;
            return finish_front(
                Subscribed{operation.id, message.topic_id, mqttsn::qos_in(message.flags)},
                call.out);
        case MsgType::unsubscribe:
            return finish_front(Unsubscribed{operation.id}, call.out);
        case MsgType::publish:
            if (type == MsgType::regack) return postpone_front();
            return finish_front(Published{operation.id}, call.out);
        default:
            return finish_front(WillUpdated{operation.id}, call.out);
    }
}

}  // namespace romano::client
