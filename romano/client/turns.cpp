// The operations one after the other, since only one exchange may be open (6.5c, 6.6c, 6.9g).
#include <algorithm>

#include "romano/client/client.h"
#include "romano/mqttsn/cell.h"

namespace romano::client {

using mqttsn::MsgType;
using mqttsn::ReturnCode;
using mqttsn::TopicIdType;

namespace {

bool is_qos0(const Operation& operation) {
    return operation.request == MsgType::publish && operation.qos() == mqttsn::Qos::at_most_once;
}

bool names_something(const mqttsn::TopicRef& topic) {
    if (topic.type == TopicIdType::predefined) return true;
    return !topic.name.empty() && (topic.type == TopicIdType::normal || topic.name.size() <= 2);
}

}  // namespace

Result<OperationId, Refusal> ClientCore::request(MsgType request, const mqttsn::TopicRef& topic,
                                                 Bytes data, const PublishOptions& options,
                                                 const Call& call) {
    if (!names_something(topic)) {
        call.out.clear();
        return Refusal::invalid_topic;
    }
    const auto flags = mqttsn::to_wire(
        {.qos = options.qos, .retain = options.retain, .topic_id_type = topic.type});
    std::uint8_t id[2];
    put_be16(id, 0, static_cast<std::uint16_t>(topic.id));
    const std::string_view name = topic.type == TopicIdType::predefined ? as_text(id) : topic.name;
    return enqueue({.request = request, .flags = flags}, name, data, call);
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
    const MsgType request = operations_.front().request;
    switch (request) {
        case MsgType::publish:
            return begin_publish(call);
        case MsgType::subscribe:
            return begin_subscribe(call);
        case MsgType::register_:
            return begin_register(call);
        case MsgType::unsubscribe:
            if (hears_cells && operations_.front_name() == mqttsn::cell_topic) listens_ = false;
            return send_first(request, next_msg_id(), call);
        default:
            return send_first(request, mqttsn::no_msg_id, call);
    }
}

/// Sends what the front comes to next, and awaits its answer.
void ClientCore::send_first(MsgType type, mqttsn::MsgId msg_id, const Call& call) {
    operations_.front().sent = type;
    operations_.front().msg_id = msg_id;
    start_exchange(call.now);
    send_front(false, call.out);
}

void ClientCore::send_front(bool dup, Output& out) {
    const Operation& operation = operations_.front();
    const MsgType type = operation.sent;
    mqttsn::Body body{.flags = operation.flags,
                      .topic_id = operation.topic_id,
                      .msg_id = operation.msg_id,
                      .rest = as_octets(operations_.front_name())};
    if (type == MsgType::publish || type == MsgType::willmsgupd) {
        body.rest = operations_.front_data();
    }
    const bool can_be_dup = type == MsgType::publish || type == MsgType::subscribe;
    if (dup && can_be_dup) body.flags |= mqttsn::to_wire({.dup = true});
    out.send(type, body);
}

/// The front was on its way when the connection ended. A kept session knows its message id; in a
/// clean one it begins anew, except that PUBREL is answered by any broker (6.6d).
void ClientCore::resume_front(const Call& call) {
    if (operations_.empty() || operations_.front().sent == Operation::nothing) return;
    if (options_.clean_session && operations_.front().sent != MsgType::pubrel) {
        return postpone_front();
    }
    start_exchange(call.now);
    send_front(true, call.out);
}

/// It begins anew when its turn comes.
void ClientCore::postpone_front() {
    exchange_.stop();
    operations_.front().sent = Operation::nothing;
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
