#include "experiments/operator/node_watch.h"

#include <functional>
#include <utility>
#include <variant>

namespace romano::experiments {

NodeWatch::NodeWatch(boost::asio::io_context& io, const BrokerAddress& broker,
                     const std::string& client_id, const client::Timing& timing,
                     std::shared_ptr<keys::ClientPackets> packets)
    : client_id_(client_id),
      client_(std::make_unique<WatcherClient>(
          io, broker, timing, std::hash<std::string>{}(client_id),
          [this](const client::Event& event) { on_event(event); }, std::move(packets))) {
    client_->connect({.client_id = client_id_, .clean_session = true});
}

void NodeWatch::subscribe(const std::string& filter) {
    (void)client_->subscribe(client::topic_name(filter), mqttsn::Qos::at_least_once);
}

void NodeWatch::publish(const std::string& topic, Bytes data, mqttsn::Qos qos) {
    if (!client_->publish(client::topic_name(topic), data, {.qos = qos})) failed_ = true;
}

void NodeWatch::on_event(const client::Event& event) {
    if (const auto* received = std::get_if<client::Received>(&event)) {
        ++heard_;
        const std::string_view topic = received->topic.name;
        if (on_message_) on_message_(topic, received->data);
        const auto entry = server::parse_entry(topic, as_text(received->data));
        if (entry) nodes_.insert_or_assign(entry->id, *entry);
        if (received->data.empty()) {  // the entry was deleted: the robot is gone
            std::erase_if(
                nodes_, [&](const auto& node) { return server::entry_topic(node.first) == topic; });
        }
        return;
    }
    if (const auto* refused = std::get_if<client::Refused>(&event)) denial_ = refused->return_code;
    if (const auto* failed = std::get_if<client::Failed>(&event)) denial_ = failed->return_code;
    if (std::holds_alternative<client::Congested>(event)) {
        denial_ = mqttsn::ReturnCode::congestion;
    }
    const auto* disconnected = std::get_if<client::Disconnected>(&event);
    failed_ = failed_ || denial_ || std::holds_alternative<client::Lost>(event) ||
              (disconnected != nullptr && disconnected->by_broker);
}

}  // namespace romano::experiments
