// MQTT-SN 1.2 sections 6.6 (publish, client to broker) and 6.8 (QoS -1).
#include "romano/client/client.h"

namespace romano::client {

using mqttsn::Qos;
using mqttsn::ReturnCode;
using mqttsn::TopicIdType;

namespace {

/// In PUBLISH a short name always fills the topic id's two octets.
bool can_be_published_on(const mqttsn::TopicRef& topic, Qos qos) {
    if (topic.type == TopicIdType::short_name) return topic.name.size() == 2;
    if (topic.type == TopicIdType::normal) return qos != Qos::without_connection;
    return topic.type == TopicIdType::predefined;
}

}  // namespace

Result<OperationId, Refusal> ClientCore::publish(Instant now, const mqttsn::TopicRef& topic,
                                                 Bytes data, const PublishOptions& options,
                                                 Output& out) {
    out.clear();
    if (!can_be_published_on(topic, options.qos)) return Refusal::invalid_topic;
    if (options.qos == Qos::at_most_once && state_ == State::disconnected) {
        return Refusal::not_connected;
    }
    Operation operation{.kind = Operation::Kind::publish,
                        .qos = options.qos,
                        .retain = options.retain,
                        .topic_type = topic.type};
    const auto topic_id = publish_topic_id(topic);
    if (!topic_id || !leaves_at_once(now, options.qos)) {
        return request(operation, topic, data, {now, out});
    }
    if (data.size() > most_data()) return Refusal::too_long;
    operation.id = next_operation();
    operation.topic_id = *topic_id;
    send_publish(operation, data, false, out);
    out.tell(Published{operation.id});
    return operation.id;
}

/// QoS 0 may go between two messages of an exchange (6.6c), but not before a message of QoS 0 that
/// waits for its topic's id.
bool ClientCore::leaves_at_once(Instant now, Qos qos) const {
    if (qos == Qos::without_connection) return true;
    return qos == Qos::at_most_once && state_ == State::connected && queued_qos0_ == 0 &&
           !is_paused(now);
}

/// What stands in a PUBLISH for `topic`; nothing when the name has no id yet.
std::optional<mqttsn::TopicId> ClientCore::publish_topic_id(const mqttsn::TopicRef& topic) const {
    if (topic.type == TopicIdType::normal) return topics_.id_of(topic.name);
    if (topic.type == TopicIdType::predefined) return topic.id;
    return mqttsn::TopicId{be16(as_octets(topic.name), 0)};
}

void ClientCore::begin_publish(const Call& call) {
    const auto topic_id = publish_topic_id(front_topic());
    if (!topic_id) return begin_register(call);
    Operation& operation = operations_.front();
    operation.topic_id = *topic_id;
    if (operation.qos != Qos::at_most_once) {
        return send_first(Operation::Stage::requested, next_msg_id(), call);
    }
    operation.msg_id = mqttsn::no_msg_id;
    send_publish(operation, operations_.front_data(), false, call.out);
    finish_front(Published{operation.id}, call.out);
}

void ClientCore::send_publish(const Operation& operation, Bytes data, bool dup, Output& out) {
    send(mqttsn::Publish{.dup = dup,
                         .qos = operation.qos,
                         .retain = operation.retain,
                         .topic_type = operation.topic_type,
                         .topic = operation.topic_id,
                         .msg_id = operation.msg_id,
                         .data = data},
         out);
}

void ClientCore::on_puback(const mqttsn::Puback& message, const Call& call) {
    if (!is_awaited(Operation::Kind::publish, Operation::Stage::requested, message.msg_id)) {
        return on_puback_of_qos0(message, call);
    }
    Operation& operation = operations_.front();
    if (operation.qos == Qos::exactly_once && message.return_code == ReturnCode::accepted) {
        return drop();  // never belongs to QoS 2 (6.6a)
    }
    if (message.return_code == ReturnCode::invalid_topic_id &&
        operation.topic_type == TopicIdType::normal && !operation.registered_anew) {
        on_answer(call.now);
        topics_.forget(operation.topic_id);
        operation.registered_anew = true;
        return postpone_front();
    }
    if (is_accepted(true, message.return_code, call)) {
        finish_front(Published{operation.id}, call.out);
    }
}

/// An error is answered at QoS 0 too (6.6b): the message is lost, what it says is heeded.
void ClientCore::on_puback_of_qos0(const mqttsn::Puback& message, const Call& call) {
    if (state_ != State::connected) return drop();
    if (message.return_code == ReturnCode::invalid_topic_id) {
        topics_.forget(message.topic_id);
    } else if (message.return_code == ReturnCode::congestion) {
        pause(call);
    } else {
        drop();
    }
}

/// PUBREC asks for PUBREL however often it comes.
void ClientCore::on_pubrec(const mqttsn::Pubrec& message, const Call& call) {
    constexpr auto kind = Operation::Kind::publish;
    Operation& operation = operations_.front();
    const bool first = is_awaited(kind, Operation::Stage::requested, message.msg_id) &&
                       operation.qos == Qos::exactly_once;
    const bool again = is_awaited(kind, Operation::Stage::releasing, message.msg_id);
    if (!is_accepted(first || again, ReturnCode::accepted, call)) return;
    send_first(Operation::Stage::releasing, message.msg_id, call);
}

void ClientCore::on_pubcomp(const mqttsn::Pubcomp& message, const Call& call) {
    const bool awaited = is_awaited(Operation::Stage::releasing, message.msg_id);
    if (!is_accepted(awaited, ReturnCode::accepted, call)) return;
    finish_front(Published{operations_.front().id}, call.out);
}

}  // namespace romano::client
