// The operations one after the other, since only one exchange may be open (6.5c, 6.6c, 6.9g).
#include <algorithm>

#include "romano/client/client.h"

namespace romano::client {

using mqttsn::TopicIdType;

Result<OperationId, Refusal> ClientCore::request(Instant now, Operation operation,
                                                 const mqttsn::TopicRef& topic, Bytes data,
                                                 Output& out) {
    const bool named =
        topic.type == TopicIdType::predefined ||
        (!topic.name.empty() && (topic.type == TopicIdType::normal || topic.name.size() <= 2));
    if (!named) {
        out.clear();
        return Refusal::invalid_topic;
    }
    operation.topic_type = topic.type;
    operation.topic_id = topic.id;
    return enqueue(now, operation, topic.name, data, out);
}

Result<OperationId, Refusal> ClientCore::enqueue(Instant now, const Operation& operation,
                                                 std::string_view name, Bytes data, Output& out) {
    out.clear();
    if (std::max(name.size(), data.size()) + largest_overhead > datagram_octets_) {
        return Refusal::too_long;
    }
    if (!operations_.push(operation, name, data)) return Refusal::queue_full;
    if (is_qos0(operation)) ++queued_qos0_;
    carry_on(now, out);
    return operation.id;
}

/// Begins the operations in their turn, as far as no answer is awaited.
void ClientCore::carry_on(Instant now, Output& out) {
    unfinished_ = false;
    while (state_ == State::connected && !exchange_.is_running() && !operations_.empty() &&
           !is_paused(now)) {
        if (!out.has_room()) {
            unfinished_ = true;
            return;
        }
        begin_front(now, out);
    }
}

void ClientCore::begin_front(Instant now, Output& out) {
    const Operation operation = operations_.front();
    switch (operation.kind) {
        case Operation::Kind::publish:
            return begin_publish(now, operation, out);
        case Operation::Kind::subscribe:
        case Operation::Kind::unsubscribe:
            return begin_subscribe(now, operation, out);
        case Operation::Kind::register_name:
            return begin_register(now, operation, out);
        case Operation::Kind::will_topic:
        case Operation::Kind::will_message:
            return begin_will_update(now, operation, out);
    }
}

void ClientCore::send_front_again(Output& out) {
    const Operation operation = operations_.front();
    if (operation.stage == Operation::Stage::registering) return send_register(operation, out);
    if (operation.stage == Operation::Stage::releasing) {
        return send(mqttsn::Pubrel{operation.msg_id}, out);
    }
    switch (operation.kind) {
        case Operation::Kind::publish:
            return send_publish(operation, operations_.front_data(), true, out);
        case Operation::Kind::subscribe:
        case Operation::Kind::unsubscribe:
            return send_subscribe(operation, true, out);
        case Operation::Kind::register_name:
            return;
        case Operation::Kind::will_topic:
        case Operation::Kind::will_message:
            return send_will_update(operation, out);
    }
}

/// The front was on its way when the connection ended. A kept session knows its message id; in a
/// clean one it begins anew, except that PUBREL is answered by any broker (6.6d).
void ClientCore::resume_front(Instant now, Output& out) {
    if (operations_.empty()) return;
    const Operation operation = operations_.front();
    if (operation.stage == Operation::Stage::waiting) return;
    if (options_.clean_session && operation.stage != Operation::Stage::releasing) {
        return postpone_front(operation);
    }
    exchange_.start(now, timing_.t_retry, timing_.n_retry);
    send_front_again(out);
}

void ClientCore::await_answer(Instant now, Operation operation, Operation::Stage stage) {
    operation.stage = stage;
    operations_.update_front(operation);
    exchange_.start(now, timing_.t_retry, timing_.n_retry);
}

bool ClientCore::is_awaited(Operation::Stage stage, mqttsn::MsgId msg_id) const {
    if (state_ != State::connected || !exchange_.is_running() || operations_.empty()) return false;
    const Operation operation = operations_.front();
    return operation.stage == stage && operation.msg_id == msg_id;
}

bool ClientCore::is_awaited(Operation::Kind kind, Operation::Stage stage,
                            mqttsn::MsgId msg_id) const {
    return is_awaited(stage, msg_id) && operations_.front().kind == kind;
}

mqttsn::TopicRef ClientCore::front_topic() const {
    const Operation operation = operations_.front();
    return {operation.topic_type, operations_.front_name(), operation.topic_id};
}

/// It begins anew when its turn comes.
void ClientCore::postpone_front(Operation operation) {
    exchange_.stop();
    operation.stage = Operation::Stage::waiting;
    operations_.update_front(operation);
}

void ClientCore::finish_front(const Event& event, Output& out) {
    exchange_.stop();
    if (is_qos0(operations_.front())) --queued_qos0_;
    operations_.pop();
    out.tell(event);
}

/// "Congestion" is no end: the same is asked again after T_WAIT.
void ClientCore::refuse_front(Instant now, mqttsn::ReturnCode code, Output& out) {
    if (code == mqttsn::ReturnCode::congestion) {
        postpone_front(operations_.front());
        return pause(now, out);
    }
    finish_front(Failed{operations_.front().id, code}, out);
    carry_on(now, out);
}

void ClientCore::pause(Instant now, Output& out) {
    paused_until_ = now + timing_.t_wait;
    out.tell(Congested{});
}

bool ClientCore::is_qos0(const Operation& operation) {
    return operation.kind == Operation::Kind::publish && operation.qos == mqttsn::Qos::at_most_once;
}

OperationId ClientCore::next_operation() {
    return OperationId{++last_operation_};
}

mqttsn::MsgId ClientCore::next_msg_id() {
    if (++last_msg_id_ == 0) ++last_msg_id_;  // 0 means "no message id"
    return mqttsn::MsgId{last_msg_id_};
}

}  // namespace romano::client
