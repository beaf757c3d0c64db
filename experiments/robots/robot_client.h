// An MQTT-SN client somewhere in a world: the client core, with a port of its own towards one fixed
// broker address.
//
// It counts the datagrams that it sends by message type, so that an experiment can tell whether a
// robot had to connect, register or subscribe again.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "experiments/robots/surroundings.h"
#include "romano/client/client.h"

namespace romano::experiments {

/// Room for a load that goes on while its broker is being replaced, and for a server that
/// commands many robots.
struct SocketLimits {
    static constexpr std::size_t datagram_octets = 65'507;
    static constexpr std::size_t queue_octets = 512UL * 1024;
    static constexpr std::size_t topics = 1024;
    static constexpr std::size_t name_octets = 64UL * 1024;
    static constexpr std::size_t unreleased = 64;
};

/// Room for one who listens to everything, and says something to each of thousands of robots.
struct WatcherLimits {
    static constexpr std::size_t datagram_octets = 65'507;
    static constexpr std::size_t queue_octets = 4UL * 1024 * 1024;
    static constexpr std::size_t topics = 32'768;
    static constexpr std::size_t name_octets = 4UL * 1024 * 1024;
    static constexpr std::size_t unreleased = 256;
};

/// Datagrams sent, by message type.
class SentCounts {
public:
    void count(Bytes datagram);
    [[nodiscard]] std::uint64_t of(mqttsn::MsgType type) const {
        return counts_[static_cast<std::uint8_t>(type)];
    }

private:
    std::array<std::uint32_t, 256> counts_{};
};

template <typename Limits>
class BasicRobotClient {
public:
    using OnEvent = std::function<void(const client::Event&)>;
    using Begun = Result<client::OperationId, client::Refusal>;

    /// `client_id`: that of connect(), where each client has a key of its own.
    BasicRobotClient(Surroundings& surroundings, const BrokerAddress& broker,
                     const client::Timing& timing, std::uint64_t seed, OnEvent on_event,
                     const std::string& client_id = {});

    /// `options.client_id` and the will are kept by reference, as the core does.
    void connect(const client::ConnectOptions& options);
    void disconnect();
    Begun publish(const mqttsn::TopicRef& topic, Bytes data, const client::PublishOptions& options);
    Begun subscribe(const mqttsn::TopicRef& topic, mqttsn::Qos qos);
    Begun register_name(std::string_view name);
    /// Asks whether the broker is there; ends in nothing, or in Lost.
    void probe();

    [[nodiscard]] const client::ClientCore& core() const { return core_; }
    [[nodiscard]] const SentCounts& sent() const { return sent_; }
    /// The kernel was told that nobody listens at the broker's address (ICMP).
    [[nodiscard]] bool was_refused() const { return port_->was_refused(); }
    /// Of DTLS, that it has begun.
    [[nodiscard]] std::uint64_t handshakes() const { return port_->handshakes(); }

private:
    void drain();

    Surroundings& surroundings_;
    client::Client<Limits> core_;
    OnEvent on_event_;
    SentCounts sent_;
    std::unique_ptr<Alarm> alarm_;
    std::unique_ptr<Port> port_;
};

using RobotClient = BasicRobotClient<SocketLimits>;
extern template class BasicRobotClient<SocketLimits>;
extern template class BasicRobotClient<WatcherLimits>;

}  // namespace romano::experiments
