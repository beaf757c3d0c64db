// What a client learns from a datagram to its cell (broker/core/cell.h) joins its exchanges here:
// several messages of QoS 1 may be outstanding, and the answer to one is the answer to all before
// it.
#include <cstddef>
#include <string>

#include "broker/core/delivery_flow.h"
#include "broker/core/session_deadline.h"

namespace romano::broker {

using mqttsn::MsgId;
using mqttsn::Qos;
using mqttsn::TopicIdType;
using Kind = Exchange::Kind;

namespace {

/// So many messages to the cell may wait for one client's answer.
constexpr std::size_t most_unanswered_at_cell = 16;

/// All that waits for this client went to the cell, and nothing of it was repeated.
bool awaits_cell_alone(const Session& session) {
    return session.exchange.cell_patience != Duration{0} &&
           session.queue.size() == 1 + session.begun.size();
}

}  // namespace

bool DeliveryFlow::can_take_now(Session& session, WireTopic& topic, std::string_view name,
                                Qos qos) {
    if (topic.type != TopicIdType::normal || topic.id == mqttsn::no_topic_id) return false;
    if (!can_send_at_once(session, topic, name) || !session.topics.at(topic.id)->known) {
        return false;
    }
    if (qos == Qos::at_most_once) return true;
    if (session.exchange.is_open()) {
        return awaits_cell_alone(session) && session.queue.size() < most_unanswered_at_cell;
    }
    return session.queue.empty() && session.begun.empty();
}

MsgId DeliveryFlow::follow_cell(Session& session, const MessagePtr& message, const WireTopic& topic,
                                Duration patience, Turn& turn) {
    session.queue.push({.position = message->position, .message = message});
    if (session.exchange.is_open()) {
        session.begun.push_back({message->position, next_msg_id(session)});
        return session.begun.back().msg_id;
    }
    session.queue.choose(0);
    await_cell(session, topic, patience, turn);
    return session.exchange.msg_id;
}

void DeliveryFlow::await_cell(Session& session, const WireTopic& topic, Duration patience,
                              Turn& turn) {
    Delivery& delivery = session.queue.current();
    start(session, delivery, turn);
    open(session, Kind::publishing, delivery.msg_id, topic);
    session.exchange.cell_patience = patience;
    session.exchange.sent_at = turn.now;
    session.exchange.retry_at = turn.now + patience;
    schedule(tables_, session);
}

/// A listener takes no message of the cell before it has the one before, so that its answer to one
/// is an answer to all before it. How many there are behind the front, up to the one with that id;
/// 0 when it is none of them.
std::size_t DeliveryFlow::behind_front_at_cell(const Session& session, MsgId msg_id) {
    if (session.exchange.kind != Kind::publishing || session.queue.place() != 0) return 0;
    auto delivery = session.queue.begin();
    std::size_t count = 0;
    for (const Begun& begun : session.begun) {
        if (++delivery == session.queue.end() || delivery->position != begun.position ||
            delivery->qos != Qos::at_least_once) {
            return 0;
        }
        ++count;
        if (begun.msg_id == msg_id) return count;
    }
    return 0;
}

/// The front and so many behind it are answered. What the cell was told after them has its own
/// time.
void DeliveryFlow::end_at_cell(Session& session, std::size_t behind, Turn& turn) {
    const Duration patience = session.exchange.cell_patience;
    for (std::size_t i = 0; i <= behind; ++i) end_front(session, turn);
    const bool is_told = patience != Duration{0} && !session.begun.empty() &&
                         !session.queue.empty() && !session.held &&
                         session.begun.front().position == session.queue.current().position;
    if (is_told) {
        const std::string& name = session.queue.current().message->topic;
        WireTopic topic = plain_topic(session, name);
        if (prepare(session, topic, name, turn) == Readiness::ready) {
            return await_cell(session, topic, patience, turn);
        }
    }
    go_on(session, turn);
}

}  // namespace romano::broker
