// One unmodified MQTT-SN client a broker: it has one broker address for life, subscribes once, and
// publishes when it is asked to. What it sends is counted by message type.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "experiments/robots/socket_client.h"
#include "experiments/robots/stamp.h"

namespace romano::bench {

class Robot {
public:
    /// `on_message` gets each message that comes, at the time at which it came.
    using OnMessage = std::function<void(Instant at, const experiments::Stamp& stamp)>;

    /// Without a key it speaks plain.
    Robot(boost::asio::io_context& io, std::uint32_t number,
          const experiments::BrokerAddress& broker, int qos,
          const std::shared_ptr<keys::ClientPackets>& key, OnMessage on_message);

    /// Subscribed; it knows its topic's id from that.
    [[nodiscard]] bool is_ready() const { return ready_; }
    /// The connection was lost or refused: the bench cannot go on.
    [[nodiscard]] bool has_failed() const { return failed_; }
    /// Publishes one message, unless the one before is not acknowledged yet.
    void publish();
    [[nodiscard]] std::uint64_t sent(mqttsn::MsgType type) const { return client_.sent().of(type); }
    [[nodiscard]] std::uint64_t handshakes() const { return client_.handshakes(); }

private:
    void on_event(const client::Event& event);

    std::uint32_t number_;
    std::string client_id_;
    mqttsn::Qos qos_;
    OnMessage on_message_;
    bool ready_ = false;
    bool failed_ = false;
    std::uint32_t next_sequence_ = 0;
    experiments::SocketClient client_;
};

}  // namespace romano::bench
