#include "romano/node/node.h"

#include <algorithm>
#include <cassert>

#include "romano/mqttsn/cell.h"

namespace romano::node {

using client::Event;
using message::DataType;
using mqttsn::Qos;

Node::Node(client::ClientCore& client, client::Output& scratch, romano_mailbox& mailbox,
           const NodeOptions& options)
    : client_(client), scratch_(scratch), mailbox_(mailbox), options_(options) {}

void Node::start(Instant now, Port& port) {
    connect(now, port);
}

void Node::leave(Instant now, Port& port) {
    phase_ = Phase::stopped;
    subscription_.reset();
    due_ = never;
    heartbeat_due_ = never;
    client_.disconnect(now, scratch_);
    flush(now, port);
}

void Node::on_datagram(Instant now, Bytes datagram, Port& port) {
    client_.on_datagram(now, datagram, scratch_);
    flush(now, port);
}

void Node::on_tick(Instant now, Port& port) {
    if (client_.next_wakeup() <= now) {
        client_.on_tick(now, scratch_);
        flush(now, port);
    }
    if (due_ <= now) {
        due_ = never;
        if (phase_ == Phase::connecting) {
            connect(now, port);
        } else if (phase_ == Phase::requesting) {
            send_connection_request(now, port);
        }
    }
    if (heartbeat_due_ <= now) {
        heartbeat_due_ = now + options_.heartbeat_every;
        publish_id<message::Heartbeat>(now, common_topic, Qos::at_most_once, port);
    }
}

Instant Node::next_wakeup() const {
    return std::min(client_.next_wakeup(), std::min(due_, heartbeat_due_));
}

void Node::connect(Instant now, Port& port) {
    phase_ = Phase::connecting;
    subscription_.reset();
    due_ = never;
    heartbeat_due_ = never;
    client_.connect(now,
                    {.client_id = options_.id.text(),
                     .clean_session = !options_.keep_session,
                     .keep_alive = options_.keep_alive},
                    scratch_);
    flush(now, port);
}

/// Sends what the client wants sent and heeds its events: of the answers only those to the node's
/// own subscription, for the others say that something went as it should. Handling one calls the
/// client again, which overwrites the scratch output; so a copy of it is handled last. There is one
/// at most: what a datagram or the passing of time did. Its views are into the datagram at hand.
void Node::flush(Instant now, Port& port) {
    for (const Bytes datagram : scratch_.datagrams()) port.send(datagram);
    const Event* leads_on = nullptr;
    for (const Event& event : scratch_.events()) {
        if (is_end(event)) {
            begin_again(now);
        } else if (is_progress(event)) {
            assert(leads_on == nullptr);
            leads_on = &event;
        }
    }
    if (leads_on != nullptr) on_progress(now, Event{*leads_on}, port);
}

/// A broker that refuses the node's own topics is as good as none.
bool Node::is_end(const Event& event) const {
    if (const auto* failed = std::get_if<client::Failed>(&event))
        return subscription_ == failed->operation;
    if (const auto* disconnected = std::get_if<client::Disconnected>(&event))
        return disconnected->by_broker;
    return std::holds_alternative<client::Lost>(event) ||
           std::holds_alternative<client::Refused>(event);
}

void Node::begin_again(Instant now) {
    ++counters_.connections_lost;
    phase_ = Phase::connecting;
    heartbeat_due_ = never;
    due_ = now + options_.connect_again;
}

bool Node::is_progress(const Event& event) const {
    if (const auto* subscribed = std::get_if<client::Subscribed>(&event))
        return subscription_ == subscribed->operation;
    return std::holds_alternative<client::Received>(event) ||
           std::holds_alternative<client::Connected>(event);
}

void Node::on_progress(Instant now, const Event& event, Port& port) {
    if (const auto* received = std::get_if<client::Received>(&event)) {
        on_received(now, *received, port);
    } else if (std::holds_alternative<client::Connected>(event)) {
        enter(Phase::subscribing, now, port);
    } else {
        enter(phase_ == Phase::subscribing ? Phase::requesting : Phase::established, now, port);
    }
}

void Node::enter(Phase phase, Instant now, Port& port) {
    phase_ = phase;
    due_ = never;
    subscription_.reset();
    if (phase == Phase::requesting) return send_connection_request(now, port);
    if (phase == Phase::established) {
        if (client::hears_cells && options_.listens_to_cell) {
            (void)subscribe(now, mqttsn::cell_topic, port);
        }
        if (options_.heartbeat_every > Duration{0}) heartbeat_due_ = now;
        return port.on_established();
    }
    const std::string_view topic = phase == Phase::subscribing ? options_.id.text() : common_topic;
    const auto operation =
        client_.subscribe(now, client::topic_name(topic), subscription_qos, scratch_);
    if (operation) {
        subscription_ = *operation;
    } else {  // no room: begin anew rather than wait for an answer that nobody owes
        begin_again(now);
    }
    flush(now, port);
}

void Node::send_connection_request(Instant now, Port& port) {
    due_ = now + options_.ack_timeout;
    if (!client_.is_idle()) return;  // the broker has not answered the last one yet
    ++counters_.requests_sent;
    publish_id<message::ConnectionRequest>(now, init_topic, Qos::at_least_once, port);
}

void Node::on_received(Instant now, const client::Received& received, Port& port) {
    const Bytes message = received.data;
    if (message::flaw_of(message)) {
        ++counters_.malformed;
        return;
    }
    ++counters_.received;
    const auto type = static_cast<DataType>(message[0]);
    if (received.retain && message::is_movement(type)) {  // said to whoever heard it then
        ++counters_.retained_commands;
        return;
    }
    switch (type) {
        case DataType::movement_control: {
            const auto movement = message::movement_in(message);
            (void)romano_mailbox_put(&mailbox_, static_cast<std::uint16_t>(movement.type),
                                     movement.arguments.data(),
                                     static_cast<std::uint32_t>(movement.arguments.size()));
            return;
        }
        case DataType::mqtt_subscribe:
            (void)subscribe(now, message::topic_in(message), port);
            return;
        case DataType::mqtt_unsubscribe:
            (void)client_.unsubscribe(now, client::topic_name(message::topic_in(message)),
                                      scratch_);
            return flush(now, port);
        case DataType::mqtt_publish_request: {
            const auto request = message::publish_request_in(message);
            return port.on_publish_request(request.topic, request.kind_of_data);
        }
        case DataType::connection_ack:
            if (phase_ == Phase::requesting) enter(Phase::joining, now, port);
            return;
        default:
            return port.on_message(received.topic.name, message);
    }
}

bool Node::publish_octets(Instant now, std::string_view topic, Bytes message, Qos qos, Port& port) {
    if (message.empty()) return false;
    const auto operation =
        client_.publish(now, client::topic_name(topic), message, {.qos = qos}, scratch_);
    flush(now, port);
    return operation.has_value();
}

bool Node::subscribe(Instant now, std::string_view topic, Port& port) {
    const auto operation =
        client_.subscribe(now, client::topic_name(topic), subscription_qos, scratch_);
    flush(now, port);
    return operation.has_value();
}

bool Node::request_connected_nodes(Instant now, Port& port) {
    return publish_id<message::RequestConnectedNodes>(now, init_topic, Qos::at_least_once, port);
}

}  // namespace romano::node
