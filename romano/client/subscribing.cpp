// MQTT-SN 1.2 section 6.9: subscribe and unsubscribe.
#include "romano/client/client.h"
#include "romano/mqttsn/topic.h"

namespace romano::client {

using mqttsn::ReturnCode;
using mqttsn::TopicIdType;

Result<OperationId, Refusal> ClientCore::subscribe(Instant now, const mqttsn::TopicRef& topic,
                                                   mqttsn::Qos qos, Output& out) {
    return request({.kind = Operation::Kind::subscribe, .qos = qos}, topic, {}, {now, out});
}

Result<OperationId, Refusal> ClientCore::unsubscribe(Instant now, const mqttsn::TopicRef& topic,
                                                     Output& out) {
    return request({.kind = Operation::Kind::unsubscribe}, topic, {}, {now, out});
}

/// A plain name gets an id, which must be kept to tell its messages by; wildcards get none.
void ClientCore::begin_subscribe(const Call& call) {
    const std::string_view name = operations_.front_name();
    const bool gets_id =
        operations_.front().topic_type == TopicIdType::normal && !mqttsn::has_wildcard(name);
    if (gets_id && !topics_.id_of(name) && !topics_.has_room_for(name)) {
        return fail_front(ReturnCode::congestion, call.out);
    }
    send_first(Operation::Stage::requested, next_msg_id(), call);
}

void ClientCore::on_suback(const mqttsn::Suback& message, const Call& call) {
    const bool awaited =
        is_awaited(Operation::Kind::subscribe, Operation::Stage::requested, message.msg_id);
    if (!is_accepted(awaited, message.return_code, call)) return;
    const Operation& operation = operations_.front();
    const bool has_id =
        operation.topic_type == TopicIdType::normal && mqttsn::is_assignable(message.topic_id);
    if (has_id && !topics_.put(message.topic_id, operations_.front_name())) {
        return fail_front(ReturnCode::congestion, call.out);
    }
    finish_front(Subscribed{operation.id, message.topic_id, message.qos}, call.out);
}

void ClientCore::on_unsuback(const mqttsn::Unsuback& message, const Call& call) {
    const bool awaited =
        is_awaited(Operation::Kind::unsubscribe, Operation::Stage::requested, message.msg_id);
    if (!is_accepted(awaited, ReturnCode::accepted, call)) return;
    finish_front(Unsubscribed{operations_.front().id}, call.out);
}

}  // namespace romano::client
