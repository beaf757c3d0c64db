// MQTT-SN 1.2 sections 6.6 (publish, client to broker) and 6.8 (QoS -1).
#include "romano/client/client.h"

namespace romano::client {

using mqttsn::MsgType;
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
    mqttsn::Body body;
    body.topic_id =
        topic.type == TopicIdType::predefined ? topic.id : publish_topic_id(topic.type, topic.name);
    const bool is_registered = body.topic_id != mqttsn::no_topic_id;
    if (!is_registered && topic.type != TopicIdType::normal) return Refusal::invalid_topic;
    if (!is_registered || !leaves_at_once(now, options.qos)) {
        return request(MsgType::publish, topic, data, options, {now, out});
    }
    if (data.size() > most_data()) return Refusal::too_long;
    body.flags = mqttsn::to_wire(
        {.qos = options.qos, .retain = options.retain, .topic_id_type = topic.type});
    body.rest = data;
    out.send(MsgType::publish, body);
    const OperationId id = next_operation();
    out.tell(Published{id});
    return id;
}

/// QoS 0 may go between two messages of an exchange (6.6c), but not before a message of QoS 0 that
/// waits for its topic's id.
bool ClientCore::leaves_at_once(Instant now, Qos qos) const {
    if (qos == Qos::without_connection) return true;
    return qos == Qos::at_most_once && state_ == State::connected && queued_qos0_ == 0 &&
           !is_paused(now);
}

/// What stands in a PUBLISH for `topic`; no_topic_id when the name has no id yet.
mqttsn::TopicId ClientCore::publish_topic_id(TopicIdType type, std::string_view topic) const {
    return type == TopicIdType::normal ? topics_.id_of(topic)
                                       : mqttsn::TopicId{be16(as_octets(topic), 0)};
}

void ClientCore::begin_publish(const Call& call) {
    Operation& operation = operations_.front();
    operation.topic_id = publish_topic_id(operation.topic_type(), operations_.front_name());
    if (operation.topic_id == mqttsn::no_topic_id) return begin_register(call);
    if (operation.qos() != Qos::at_most_once) {
        return send_first(MsgType::publish, next_msg_id(), call);
    }
    send_first(MsgType::publish, mqttsn::no_msg_id, call);
    finish_front(Published{operation.id}, call.out);
}

/// An error is answered at QoS 0 too (6.6b): the message is lost, what it says is heeded.
void ClientCore::on_puback_of_qos0(const mqttsn::Body& message, const Call& call) {
    if (state_ != State::connected) return drop();
    if (message.code == ReturnCode::invalid_topic_id) {
        topics_.forget(message.topic_id);
    } else if (message.code == ReturnCode::congestion) {
        pause(call);
    } else {
        drop();
    }
}

}  // namespace romano::client
