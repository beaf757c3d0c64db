#include "experiments/load/mqttsn_clients.h"

#include <algorithm>
#include <array>
#include <utility>
#include <variant>

#include "broker/net/clock.h"
#include "broker/net/endpoint_text.h"

namespace romano::experiments {
namespace {

using mqttsn::MsgType;

struct OutputLimits {
    static constexpr std::size_t datagram_octets = mqttsn::max_datagram;
};

/// All clients share it: it is used between an input and its drain only.
client::OutputFor<OutputLimits>& shared_output() {
    thread_local client::OutputFor<OutputLimits> output;
    return output;
}

/// By client. A message of a topic crosses brokers when there are as many topics as publishers and
/// subscribers.
std::vector<Endpoint> brokers_of(const LoadPlan& plan, const MqttsnOptions& options) {
    const std::vector<Endpoint>& brokers = options.brokers;
    if (brokers.size() == 1) return brokers;
    const std::size_t publishers_at = options.publishers_at.value_or(brokers.size());
    std::vector<Endpoint> of_clients;
    for (std::uint32_t i = 0; i < plan.publishers; ++i) {
        of_clients.push_back(brokers[i % publishers_at]);
    }
    for (std::uint32_t i = 0; i < plan.subscribers; ++i) {
        of_clients.push_back(brokers[(i + 1) % brokers.size()]);
    }
    return of_clients;
}

std::string texts_of(const std::vector<Endpoint>& brokers) {
    std::string text;
    for (const Endpoint& broker : brokers)
        text += (text.empty() ? "" : ", ") + net::to_text(broker);
    return text;
}

/// A client asks again after T_WAIT, for ever; a load does not begin without it.
constexpr int most_congested = 5;

std::string words_for(mqttsn::ReturnCode code) {
    const std::string number = "return code " + std::to_string(static_cast<int>(code));
    switch (code) {
        case mqttsn::ReturnCode::congestion:
            return number + ", congestion: it has no room for more";
        case mqttsn::ReturnCode::invalid_topic_id:
            return number + ", invalid topic id";
        case mqttsn::ReturnCode::not_supported:
            return number + ", not supported";
        default:
            return number;
    }
}

bool is_pingreq(Bytes datagram) {
    return datagram.size() >= 2 && datagram[1] == static_cast<std::uint8_t>(MsgType::pingreq);
}

}  // namespace

MqttsnClients::MqttsnClients(const LoadPlan& plan, const MqttsnOptions& options)
    : plan_(plan),
      options_(options),
      sockets_(brokers_of(plan, options), plan.clients(), options.sockets, cell()),
      layout_(plan) {
    for (std::uint32_t topic = 0; topic < plan.topics; ++topic) {
        topic_names_.push_back(plan.topic_name(topic));
    }
    topic_names_.emplace_back(mqttsn::cell_topic);
    rooms_.resize(layout_.octets() * plan.clients());
    for (Number number = 0; number < plan.clients(); ++number) {
        std::string id = options.id_prefix + "-" + std::to_string(number);
        if (options.keyed) {
            KeyedClient keyed = options.keyed(
                number, [this, number](Bytes datagram) { sockets_.queue(number, datagram); });
            id = std::move(keyed.client_id);
            speeches_.push_back(std::move(keyed.speech));
        }
        clients_.emplace_back(plan, std::move(id), options.timing, number, layout_,
                              room_of(number));
        if (has_cell() && number >= plan.publishers) {
            clients_.back().to_subscribe.push_back(plan.topics);  // the cell's name
        }
    }
}

MqttsnClients::~MqttsnClients() = default;

void MqttsnClients::join(Number number) {
    LoadClient& client = clients_[number];
    client.connect(
        net::now(),
        {.client_id = client.id, .clean_session = true, .keep_alive = options_.keep_alive},
        shared_output());
    drain(number);
}

void MqttsnClients::go_on_joining(Number number) {
    LoadClient& client = clients_[number];
    const std::size_t at = client.set_up++;
    if (at < client.to_subscribe.size()) {
        const std::string& name = topic_names_[client.to_subscribe[at]];
        (void)client.subscribe(now_, client::topic_name(name), plan_.qos, shared_output());
    } else if (at < client.to_subscribe.size() + client.to_register.size()) {
        const std::string& name = topic_names_[client.to_register[at - client.to_subscribe.size()]];
        (void)client.register_name(now_, name, shared_output());
    } else {
        client.joined = true;
        listener_->on_joined(number);
        return;
    }
    drain(number);
}

std::optional<LoadClients::PublishId> MqttsnClients::publish(Instant now, Number number,
                                                             std::uint32_t topic, Bytes payload) {
    LoadClient& client = clients_[number];
    if (!client.is_connected()) return std::nullopt;
    const auto begun = client.publish(now, client::topic_name(topic_names_[topic]), payload,
                                      {.qos = plan_.qos, .retain = false}, shared_output());
    if (!begun) return std::nullopt;
    drain(number);
    return static_cast<PublishId>(*begun);
}

void MqttsnClients::turn(Instant until) {
    sockets_.flush();
    sockets_.receive(std::min(until, deadlines_.next()), *this);
    now_ = net::now();
    tick(now_);
    sockets_.flush();
}

/// Among ten thousand clients most of the work on a datagram is waiting for memory.
void MqttsnClients::expect(Number number) {
    clients_[number].prefetch();
    __builtin_prefetch(room_of(number));
}

void MqttsnClients::on_datagram(Instant now, Number number, Bytes octets) {
    now_ = now;
    if (!speeches_.empty()) {
        octets = speeches_[number]->open(octets);
        if (octets.empty()) return;  // a handshake's, or none for this client
    }
    clients_[number].on_datagram(now, octets, shared_output());
    drain(number);
}

/// What a handshake loses is not repeated here: another one comes with a later CONNECT.
void MqttsnClients::send(Number number, Bytes message) {
    if (speeches_.empty()) return sockets_.queue(number, message);
    speeches_[number]->send(message);
}

void MqttsnClients::tick(Instant now) {
    while (deadlines_.next() <= now) {
        const Number number = deadlines_.pop();
        LoadClient& client = clients_[number];
        if (client.next_wakeup() <= now) {
            client.on_tick(now, shared_output());
            for (const Bytes datagram : shared_output().datagrams()) {
                if (!is_pingreq(datagram)) ++retransmissions_;
            }
            drain(number);
        }
        deadlines_.no_later_than(number, client.next_wakeup());
    }
}

void MqttsnClients::drain(Number number) {
    const auto& output = shared_output();
    for (const Bytes message : output.datagrams()) send(number, message);
    deadlines_.no_later_than(number, clients_[number].next_wakeup());
    // An event's owner may call back into this client, which empties the shared output.
    std::array<client::Event, client::Output::most> events;
    const std::size_t count = output.events().size();
    for (std::size_t i = 0; i < count; ++i) events[i] = output.events()[i];
    for (std::size_t i = 0; i < count; ++i) on_event(number, events[i]);
}

void MqttsnClients::on_event(Number number, const client::Event& event) {
    if (const auto* received = std::get_if<client::Received>(&event)) {
        listener_->on_message(now_, number, received->data, received->dup);
    } else if (const auto* published = std::get_if<client::Published>(&event)) {
        if (plan_.qos == mqttsn::Qos::at_most_once) return;
        listener_->on_published(now_, number, static_cast<PublishId>(published->operation), true);
    } else if (std::holds_alternative<client::Connected>(event) ||
               std::holds_alternative<client::Subscribed>(event) ||
               std::holds_alternative<client::Registered>(event)) {
        if (!clients_[number].joined) go_on_joining(number);
    } else if (const auto* failed = std::get_if<client::Failed>(&event)) {
        if (clients_[number].joined) {
            listener_->on_published(now_, number, static_cast<PublishId>(failed->operation), false);
        } else {
            listener_->on_trouble(number, "the broker refused a subscription or a topic of " +
                                              clients_[number].id + ": " +
                                              words_for(failed->return_code));
        }
    } else if (std::holds_alternative<client::Congested>(event)) {
        if (clients_[number].joined || ++clients_[number].congested < most_congested) return;
        listener_->on_trouble(number, "the broker has no room for a subscription or a topic of " +
                                          clients_[number].id + " (congestion, " +
                                          std::to_string(most_congested) + " times)");
    } else if (const auto* refused = std::get_if<client::Refused>(&event)) {
        listener_->on_trouble(number, "the broker refused the connection of " +
                                          clients_[number].id + ": " +
                                          words_for(refused->return_code));
    } else if (std::holds_alternative<client::Lost>(event)) {
        listener_->on_trouble(number, loss(number));
    } else if (const auto* disconnected = std::get_if<client::Disconnected>(&event)) {
        if (disconnected->by_broker) {
            listener_->on_trouble(number, "the broker disconnected " + clients_[number].id);
        }
    }
}

std::string MqttsnClients::loss(Number number) const {
    const std::string where = texts_of(options_.brokers);
    if (clients_[number].set_up > 0) {
        return "the broker at " + where + " answered " + clients_[number].id + " no more";
    }
    return sockets_.was_refused() ? "no broker serves at " + where + ": nobody listens there"
                                  : "no broker answered at " + where;
}

void MqttsnClients::leave() {
    for (Number number = 0; number < clients_.size(); ++number) {
        if (!clients_[number].is_connected()) continue;
        clients_[number].disconnect(net::now(), shared_output());
        for (const Bytes message : shared_output().datagrams()) send(number, message);
    }
    sockets_.flush();
}

}  // namespace romano::experiments
