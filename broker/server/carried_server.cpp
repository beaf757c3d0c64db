#include "broker/server/carried_server.h"

#include <algorithm>
#include <memory>
#include <utility>

namespace romano::broker {
namespace {

class BrokerHost final : public server::Host {
public:
    BrokerHost(Instant now, BrokerCore& broker, std::span<const LogId> led, Actions& actions)
        : now_(now), broker_(broker), led_(led), actions_(actions) {}

    [[nodiscard]] std::optional<server::Standing> standing(std::string_view client) const override {
        const SessionHeader* header = broker_.header(client);
        if (header == nullptr) return std::nullopt;
        const bool departed =
            header->state == SessionState::disconnected || header->state == SessionState::lost;
        return server::Standing{.connected = !departed, .kept = !header->clean};
    }

    [[nodiscard]] std::vector<server::NodeEntry> entries() const override {
        std::vector<server::NodeEntry> found;
        for (const auto& message : broker_.retained(server::entries_filter)) {
            auto entry = server::parse_entry(message->topic, as_text(message->payload));
            if (entry) found.push_back(std::move(*entry));
        }
        return found;
    }

    [[nodiscard]] bool tidies_up_after(std::string_view home) const override {
        const auto id = broker_id_of(home);
        return !led_.empty() && std::ranges::count(led_, id, &LogId::broker) == 0;
    }

    void publish(std::string_view topic, Bytes data, bool retain) override {
        // A node gets what is for it at the QoS of its own subscription.
        const auto qos = retain ? mqttsn::Qos::at_least_once : mqttsn::Qos::exactly_once;
        broker_.publish(now_, topic, data, qos, retain, actions_);
    }
    void hold(std::string_view client, bool held) override {
        broker_.hold(now_, client, held, actions_);
    }

private:
    Instant now_;
    BrokerCore& broker_;
    std::span<const LogId> led_;
    Actions& actions_;
};

}  // namespace

std::vector<std::string> CarriedServer::observed_topics() {
    return {server::observed_topics.begin(), server::observed_topics.end()};
}

bool CarriedServer::is_never_retained(std::string_view topic, Bytes payload) {
    return server::is_never_retained(topic, payload);
}

void CarriedServer::answer(Instant now, BrokerCore& broker, Actions& actions) {
    BrokerHost host{now, broker, {}, actions};
    for (std::size_t i = 0; i < actions.list().size(); ++i) {  // answers are added to it
        auto* observed = std::get_if<Observed>(&actions.list()[i]);
        if (observed == nullptr || observed->what == nullptr) continue;
        const std::unique_ptr<Observation> what = std::move(observed->what);
        core_.on_publish(now, what->publisher, what->topic, what->payload, host);
    }
}

void CarriedServer::on_tick(Instant now, BrokerCore& broker, std::span<const LogId> led,
                            Actions& actions) {
    if (now < core_.next_wakeup()) return;
    BrokerHost host{now, broker, led, actions};
    core_.on_tick(now, host);
}

}  // namespace romano::broker
