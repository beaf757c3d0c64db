// An MQTT-SN client on a UDP socket of its own: the client core, and an Asio shell around it.
//
// The socket talks to one fixed broker address and hears nobody else. It counts the datagrams that
// it sends by message type, so that an experiment can tell whether a robot had to connect,
// register or subscribe again.
#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "broker/net/core_timer.h"
#include "romano/client/client.h"
#include "romano/keys/client_packets.h"

namespace romano::experiments {

using BrokerAddress = boost::asio::ip::udp::endpoint;

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
class BasicSocketClient {
public:
    using OnEvent = std::function<void(const client::Event&)>;
    using Begun = Result<client::OperationId, client::Refusal>;

    /// With `packets`, all that it says and hears is protected.
    BasicSocketClient(boost::asio::io_context& io, const BrokerAddress& broker,
                      const client::Timing& timing, std::uint64_t seed, OnEvent on_event,
                      std::shared_ptr<keys::ClientPackets> packets = nullptr);

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
    [[nodiscard]] bool was_refused() const { return was_refused_; }

private:
    void receive();
    void drain();
    void tick();

    boost::asio::ip::udp::socket socket_;
    client::Client<Limits> core_;
    OnEvent on_event_;
    std::shared_ptr<keys::ClientPackets> packets_;  // null: plain
    net::CoreTimer timer_;
    SentCounts sent_;
    bool was_refused_ = false;
};

using SocketClient = BasicSocketClient<SocketLimits>;
extern template class BasicSocketClient<SocketLimits>;
/// Of 8 MB: not one that many are made of, nor one for the stack.
using WatcherClient = BasicSocketClient<WatcherLimits>;
extern template class BasicSocketClient<WatcherLimits>;

/// Looks `host` up: a name, an IPv4 or an IPv6 address. Throws std::runtime_error with a sentence.
[[nodiscard]] BrokerAddress resolve_broker(boost::asio::io_context& io, const std::string& host,
                                           std::uint16_t port);

}  // namespace romano::experiments
