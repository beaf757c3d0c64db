// Looks at the ROMANO nodes with one broker's eyes: a plain MQTT-SN client that subscribes to
// entries on $ROMANO/nodes/ and keeps the latest of each; and publishes to nodes.
#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "experiments/robots/socket_client.h"
#include "romano/message/romano_id.h"
#include "romano/server/node_entry.h"

namespace romano::experiments {

class NodeWatch {
public:
    NodeWatch(boost::asio::io_context& io, const BrokerAddress& broker,
              const std::string& client_id, const client::Timing& timing,
              std::shared_ptr<keys::ClientPackets> packets = nullptr);

    /// Told of each message besides, before it is heeded here.
    using OnMessage = std::function<void(std::string_view topic, Bytes data)>;
    void set_on_message(OnMessage on_message) { on_message_ = std::move(on_message); }

    void subscribe(const std::string& filter);
    void publish(const std::string& topic, Bytes data, mqttsn::Qos qos);
    void leave() { client_->disconnect(); }

    [[nodiscard]] const std::map<message::RomanoId, server::NodeEntry>& nodes() const {
        return nodes_;
    }
    [[nodiscard]] bool is_connected() const { return client_->core().is_connected(); }
    [[nodiscard]] bool is_idle() const { return client_->core().is_idle(); }
    /// Words of the broker on nodes so far.
    [[nodiscard]] std::size_t heard() const { return heard_; }
    /// No answer after all repetitions, or a refusal.
    [[nodiscard]] bool has_failed() const { return failed_; }
    /// The broker answered, with a refusal.
    [[nodiscard]] std::optional<mqttsn::ReturnCode> denial() const { return denial_; }
    [[nodiscard]] bool was_refused() const { return client_->was_refused(); }

private:
    void on_event(const client::Event& event);

    std::string client_id_;
    OnMessage on_message_;
    std::map<message::RomanoId, server::NodeEntry> nodes_;
    std::size_t heard_ = 0;
    bool failed_ = false;
    std::optional<mqttsn::ReturnCode> denial_;
    std::unique_ptr<WatcherClient> client_;  // one robot's entry is a topic for it
};

}  // namespace romano::experiments
