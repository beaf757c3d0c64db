#include "experiments/watch/broker_watch.h"

#include <algorithm>
#include <utility>

namespace romano::experiments {

BrokerWatch::BrokerWatch(Surroundings& surroundings, const BrokerAddress& broker,
                         const std::string& client_id, const client::Timing& timing,
                         std::function<void()> on_change, mqttsn::Qos qos)
    : client_id_(client_id),
      on_change_(std::move(on_change)),
      qos_(qos),
      client_(
          surroundings, broker, timing, std::hash<std::string>{}(client_id),
          [this](const client::Event& event) { on_event(event); }, client_id) {
    connect();
}

void BrokerWatch::connect() {
    client_.connect({.client_id = client_id_, .clean_session = true});
}

void BrokerWatch::leave() {
    leaving_ = true;
    client_.disconnect();
}

void BrokerWatch::on_event(const client::Event& event) {
    if (std::holds_alternative<client::Connected>(event)) {
        (void)client_.subscribe(client::topic_name(brokers_filter), qos_);
    } else if (std::holds_alternative<client::Subscribed>(event)) {
        subscribed_ = true;
    } else if (std::holds_alternative<client::Lost>(event)) {
        failed_ = true;
    } else if (const auto* refused = std::get_if<client::Refused>(&event)) {
        failed_ = true;
        denial_ = refused->return_code;
    } else if (const auto* denied = std::get_if<client::Failed>(&event)) {
        failed_ = true;
        denial_ = denied->return_code;
    } else if (std::holds_alternative<client::Congested>(event)) {
        failed_ = true;
        denial_ = mqttsn::ReturnCode::congestion;
    } else if (std::holds_alternative<client::Disconnected>(event)) {
        // A broker that is asked while it starts may not know its clients a moment later.
        if (!leaving_) connect();
    } else if (const auto* received = std::get_if<client::Received>(&event)) {
        auto status = parse_broker_status(as_text(received->data));
        if (!status) return;
        std::string name = status->name;
        brokers_.insert_or_assign(std::move(name),
                                  Seen{std::move(*status), std::string{as_text(received->data)}});
        if (on_change_) on_change_();
    }
}

std::size_t BrokerWatch::alive() const {
    return static_cast<std::size_t>(std::ranges::count_if(
        brokers_, [](const auto& entry) { return entry.second.status.alive; }));
}

std::size_t BrokerWatch::members_in_view_of(const std::string& broker) const {
    const auto seen = brokers_.find(broker);
    return seen == brokers_.end() ? 0 : seen->second.status.view_members.size();
}

std::optional<std::string> BrokerWatch::leader() const {
    for (const auto& [name, seen] : brokers_) {
        if (seen.status.alive && seen.status.leader) return name;
    }
    return std::nullopt;
}

}  // namespace romano::experiments
