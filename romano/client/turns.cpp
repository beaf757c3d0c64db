// The operations one after the other, since only one exchange may be open (6.5c, 6.6c, 6.9g).
#include <algorithm>

#include "romano/client/client.h"

namespace romano::client {

using mqttsn::ReturnCode;
using mqttsn::TopicIdType;

namespace {

bool is_qos0(const Operation& operation) {
    return operation.kind == Operation::Kind::publish && operation.qos == mqttsn::Qos::at_most_once;
}

bool names_something(const mqttsn::TopicRef& topic) {
    if (topic.type == TopicIdType::predefined) return true;
    return !topic.name.empty() && (topic.type == TopicIdType::normal || topic.name.size() <= 2);
}

}  // namespace

Result<OperationId, Refusal> ClientCore::request(Operation operation, const mqttsn::TopicRef& topic,
                                                 Bytes data, const Call& call) {
    if (!names_something(topic)) {
        call.out.clear();
        return Refusal::invalid_topic;
    }
    operation.topic_type = topic.type;
    operation.topic_id = topic.id;
    return enqueue(operation, topic.name, data, call);
}

Result<OperationId, Refusal> ClientCore::enqueue(Operation operation, std::string_view name,
                                                 Bytes data, const Call& call) {
    call.out.clear();
    if (std::max(name.size(), data.size()) > most_data()) return Refusal::too_long;
    operation.id = next_operation();
    if (!operations_.push(operation, name, data)) return Refusal::queue_full;
    if (is_qos0(operation)) ++queued_qos0_;
    carry_on(call);
    return operation.id;
}

/// Begins the operations in their turn, as far as no answer is awaited.
void ClientCore::carry_on(const Call& call) {
    unfinished_ = false;
    while (state_ == State::connected && !exchange_.is_running() && !operations_.empty() &&
           !is_paused(call.now)) {
        if (!call.out.has_room()) {
            unfinished_ = true;
            return;
        }
        begin_front(call);
    }
}

void ClientCore::begin_front(const Call& call) {
    switch (operations_.front().kind) {
        case Operation::Kind::publish:
            return begin_publish(call);
        case Operation::Kind::subscribe:
            return begin_subscribe(call);
        case Operation::Kind::unsubscribe:
            return send_first(Operation::Stage::requested, next_msg_id(), call);
        case Operation::Kind::register_name:
            return begin_register(call);
        case Operation::Kind::will_topic:
        case Operation::Kind::will_message:
            return send_first(Operation::Stage::requested, mqttsn::no_msg_id, call);
    }
}

/// Sends the request that belongs to `stage`, and awaits its answer.
void ClientCore::send_first(Operation::Stage stage, mqttsn::MsgId msg_id, const Call& call) {
    operations_.front().stage = stage;
    operations_.front().msg_id = msg_id;
    start_exchange(call.now);
    send_front(false, call.out);
}

void ClientCore::send_front(bool dup, Output& out) {
    const Operation& operation = operations_.front();
    const std::string_view name = operations_.front_name();
    if (operation.stage == Operation::Stage::registering) {
        return send(mqttsn::Register{mqttsn::no_topic_id, operation.msg_id, name}, out);
    }
    if (operation.stage == Operation::Stage::releasing) {
        return send(mqttsn::Pubrel{operation.msg_id}, out);
    }
    switch (operation.kind) {
        case Operation::Kind::publish:
            return send_publish(operation, operations_.front_data(), dup, out);
        case Operation::Kind::subscribe:
            return send(mqttsn::Subscribe{dup, operation.qos, operation.msg_id, front_topic()},
                        out);
        case Operation::Kind::unsubscribe:
            return send(mqttsn::Unsubscribe{operation.msg_id, front_topic()}, out);
        case Operation::Kind::will_topic:
            return send(mqttsn::Willtopicupd{operation.qos, operation.retain, name}, out);
        case Operation::Kind::will_message:
            return send(mqttsn::Willmsgupd{operations_.front_data()}, out);
        case Operation::Kind::register_name:  // has no other stage than registering
            return;
    }
}

/// The front was on its way when the connection ended. A kept session knows its message id; in a
/// clean one it begins anew, except that PUBREL is answered by any broker (6.6d).
void ClientCore::resume_front(const Call& call) {
    if (operations_.empty() || operations_.front().stage == Operation::Stage::waiting) return;
    if (options_.clean_session && operations_.front().stage != Operation::Stage::releasing) {
        return postpone_front();
    }
    start_exchange(call.now);
    send_front(true, call.out);
}

bool ClientCore::is_awaited(Operation::Stage stage, mqttsn::MsgId msg_id) const {
    return state_ == State::connected && exchange_.is_running() && !operations_.empty() &&
           operations_.front().stage == stage && operations_.front().msg_id == msg_id;
}

bool ClientCore::is_awaited(Operation::Kind kind, Operation::Stage stage,
                            mqttsn::MsgId msg_id) const {
    return operations_.front().kind == kind && is_awaited(stage, msg_id);
}

/// False when there is nothing left to do about an answer: nobody awaited it, or it is a refusal.
/// "Congestion" is no end: the same is asked again after T_WAIT.
bool ClientCore::is_accepted(bool awaited, ReturnCode code, const Call& call) {
    if (!awaited) {
        drop();
        return false;
    }
    on_answer(call.now);
    if (code == ReturnCode::accepted) return true;
    if (code == ReturnCode::congestion) {
        postpone_front();
        pause(call);
    } else {
        fail_front(code, call.out);
    }
    return false;
}

mqttsn::TopicRef ClientCore::front_topic() const {
    const Operation& operation = operations_.front();
    return {operation.topic_type, operations_.front_name(), operation.topic_id};
}

/// It begins anew when its turn comes.
void ClientCore::postpone_front() {
    exchange_.stop();
    operations_.front().stage = Operation::Stage::waiting;
}

void ClientCore::finish_front(const Event& event, Output& out) {
    exchange_.stop();
    if (is_qos0(operations_.front())) --queued_qos0_;
    operations_.pop();
    out.tell(event);
}

void ClientCore::fail_front(ReturnCode code, Output& out) {
    finish_front(Failed{operations_.front().id, code}, out);
}

void ClientCore::pause(const Call& call) {
    paused_until_ = call.now + timing_.t_wait;
    call.out.tell(Congested{});
}

mqttsn::MsgId ClientCore::next_msg_id() {
    if (++last_msg_id_ == 0) ++last_msg_id_;  // 0 means "no message id"
    return mqttsn::MsgId{last_msg_id_};
}

}  // namespace romano::client
