#include "romano/node/node.h"

#include <algorithm>
#include <cassert>

namespace romano::node {

using client::Event;
using mqttsn::Qos;

Node::Node(client::ClientCore& client, client::Output& scratch, romano_mailbox& mailbox,
           const NodeOptions& options)
    : client_(client), scratch_(scratch), mailbox_(mailbox), options_(options) {}

void Node::start(Instant now, Port& port) {
    connect(now, port);
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
    return std::min({client_.next_wakeup(), due_, heartbeat_due_});
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

/// Sends what the client wants sent and works through its events. Handling one calls the client
/// again, which overwrites the scratch output: so events wait here, and the call that is outermost
/// handles them, in order. Their views are into the datagram at hand.
void Node::flush(Instant now, Port& port) {
    for (const Bytes datagram : scratch_.datagrams()) port.send(datagram);
    for (const Event& event : scratch_.events()) {
        if (!is_heeded(event)) continue;
        [[maybe_unused]] const bool has_room = events_.push_back(event);
        assert(has_room);
    }
    if (!handles_events_) handle_events(now, port);
}

/// Of the answers only those to the node's own subscription; the others say that something went as
/// it should. So a call of the client brings one such event: what a datagram or the passing of time
/// did, and at the very most the failure of that subscription behind it.
bool Node::is_heeded(const Event& event) const {
    if (const auto* subscribed = std::get_if<client::Subscribed>(&event))
        return subscription_ == subscribed->operation;
    if (const auto* failed = std::get_if<client::Failed>(&event))
        return subscription_ == failed->operation;
    return std::holds_alternative<client::Received>(event) ||
           std::holds_alternative<client::Connected>(event) ||
           std::holds_alternative<client::Lost>(event) ||
           std::holds_alternative<client::Refused>(event) ||
           std::holds_alternative<client::Disconnected>(event);
}

void Node::handle_events(Instant now, Port& port) {
    handles_events_ = true;
    while (!events_.empty()) {
        const Event event = events_[0];
        events_.erase_at(0);
        on_event(now, event, port);
    }
    handles_events_ = false;
}

void Node::on_event(Instant now, const Event& event, Port& port) {
    if (const auto* received = std::get_if<client::Received>(&event))
        return on_received(now, *received, port);
    if (std::holds_alternative<client::Connected>(event)) {
        phase_ = Phase::subscribing;
        return follow_up(now, port);
    }
    if (std::holds_alternative<client::Subscribed>(event)) {
        subscription_.reset();
        phase_ = phase_ == Phase::subscribing ? Phase::requesting : Phase::established;
        return follow_up(now, port);
    }
    if (std::holds_alternative<client::Failed>(event)) {
        // A broker that refuses the node's own topics is as good as none.
        phase_ = Phase::connecting;
        due_ = now + options_.connect_again;
        return;
    }
    const auto* disconnected = std::get_if<client::Disconnected>(&event);
    const bool lost = std::holds_alternative<client::Lost>(event) ||
                      std::holds_alternative<client::Refused>(event) ||
                      (disconnected != nullptr && disconnected->by_broker);
    if (lost) {
        ++counters_.connections_lost;
        phase_ = Phase::connecting;
        heartbeat_due_ = never;
        due_ = now + options_.connect_again;
    }
}

/// What the phase that has just begun asks for.
void Node::follow_up(Instant now, Port& port) {
    switch (phase_) {
        case Phase::subscribing:
        case Phase::joining: {
            const std::string_view topic =
                phase_ == Phase::subscribing ? options_.id.text() : common_topic;
            const auto operation =
                client_.subscribe(now, client::topic_name(topic), options_.qos, scratch_);
            if (operation) {
                subscription_ = *operation;
            } else {  // no room: begin anew rather than wait for an answer that nobody owes
                phase_ = Phase::connecting;
                due_ = now + options_.connect_again;
            }
            return flush(now, port);
        }
        case Phase::requesting:
            return send_connection_request(now, port);
        case Phase::established:
            if (options_.heartbeat_every > Duration{0}) heartbeat_due_ = now;
            return port.on_established();
        default:
            return;
    }
}

void Node::send_connection_request(Instant now, Port& port) {
    due_ = now + options_.ack_timeout;
    if (!client_.is_idle()) return;  // the broker has not answered the last one yet
    ++counters_.requests_sent;
    publish_id<message::ConnectionRequest>(now, init_topic, options_.qos, port);
}

void Node::on_received(Instant now, const client::Received& received, Port& port) {
    const auto message = message::decode(received.data);
    if (!message) {
        ++counters_.malformed;
        return;
    }
    ++counters_.received;
    if (const auto* movement = std::get_if<message::MovementControl>(&*message)) {
        (void)romano_mailbox_put(&mailbox_, static_cast<std::uint16_t>(movement->type),
                                 movement->arguments.data(),
                                 static_cast<std::uint32_t>(movement->arguments.size()));
    } else if (const auto* wanted = std::get_if<message::MqttSubscribe>(&*message)) {
        subscribe(now, wanted->topic, port);
    } else if (const auto* unwanted = std::get_if<message::MqttUnsubscribe>(&*message)) {
        (void)client_.unsubscribe(now, client::topic_name(unwanted->topic), scratch_);
        flush(now, port);
    } else if (const auto* request = std::get_if<message::MqttPublishRequest>(&*message)) {
        port.on_publish_request(request->topic, request->kind_of_data);
    } else if (std::holds_alternative<message::ConnectionAck>(*message)) {
        if (phase_ != Phase::requesting) return;
        phase_ = Phase::joining;
        due_ = never;
        follow_up(now, port);
    } else {
        port.on_message(received.topic.name, *message);
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
        client_.subscribe(now, client::topic_name(topic), options_.qos, scratch_);
    flush(now, port);
    return operation.has_value();
}

bool Node::request_connected_nodes(Instant now, Port& port) {
    return publish_id<message::RequestConnectedNodes>(now, init_topic, options_.qos, port);
}

}  // namespace romano::node
