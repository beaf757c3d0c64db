// MQTT-SN 1.2 section 6.9: subscribe and unsubscribe.
#include "romano/client/client.h"
#include "romano/mqttsn/topic.h"

namespace romano::client {

using mqttsn::ReturnCode;
using mqttsn::TopicIdType;

Result<OperationId, Refusal> ClientCore::subscribe(Instant now, const mqttsn::TopicRef& topic,
                                                   mqttsn::Qos qos, Output& out) {
    return request(now, {.id = next_operation(), .kind = Operation::Kind::subscribe, .qos = qos},
                   topic, {}, out);
}

Result<OperationId, Refusal> ClientCore::unsubscribe(Instant now, const mqttsn::TopicRef& topic,
                                                     Output& out) {
    return request(now, {.id = next_operation(), .kind = Operation::Kind::unsubscribe}, topic, {},
                   out);
}

/// A plain name gets an id, which must be kept to tell its messages by; wildcards get none.
void ClientCore::begin_subscribe(Instant now, Operation operation, Output& out) {
    const std::string_view name = operations_.front_name();
    const bool gets_id = operation.kind == Operation::Kind::subscribe &&
                         operation.topic_type == TopicIdType::normal && !mqttsn::has_wildcard(name);
    if (gets_id && !topics_.id_of(name) && !topics_.has_room_for(name)) {
        return finish_front(Failed{operation.id, ReturnCode::congestion}, out);
    }
    operation.msg_id = next_msg_id();
    await_answer(now, operation, Operation::Stage::requested);
    send_subscribe(operation, false, out);
}

void ClientCore::send_subscribe(const Operation& operation, bool dup, Output& out) {
    if (operation.kind == Operation::Kind::subscribe) {
        send(mqttsn::Subscribe{dup, operation.qos, operation.msg_id, front_topic()}, out);
    } else {
        send(mqttsn::Unsubscribe{operation.msg_id, front_topic()}, out);
    }
}

void ClientCore::on_suback(Instant now, const mqttsn::Suback& message, Output& out) {
    if (!is_awaited(Operation::Kind::subscribe, Operation::Stage::requested, message.msg_id)) {
        return drop();
    }
    on_answer(now);
    if (message.return_code != ReturnCode::accepted) {
        return refuse_front(now, message.return_code, out);
    }
    const Operation operation = operations_.front();
    const bool has_id =
        operation.topic_type == TopicIdType::normal && mqttsn::is_assignable(message.topic_id);
    if (has_id && !topics_.put(message.topic_id, operations_.front_name())) {
        finish_front(Failed{operation.id, ReturnCode::congestion}, out);
    } else {
        finish_front(Subscribed{operation.id, message.topic_id, message.qos}, out);
    }
    carry_on(now, out);
}

void ClientCore::on_unsuback(Instant now, const mqttsn::Unsuback& message, Output& out) {
    if (!is_awaited(Operation::Kind::unsubscribe, Operation::Stage::requested, message.msg_id)) {
        return drop();
    }
    on_answer(now);
    finish_front(Unsubscribed{operations_.front().id}, out);
    carry_on(now, out);
}

}  // namespace romano::client
