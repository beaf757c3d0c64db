// A client on a UDP socket of its own, in the real world.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <string>
#include <utility>

#include "experiments/robots/robot_client.h"
#include "experiments/robots/sockets.h"

namespace romano::experiments {

template <typename Limits>
class BasicSocketClient : private Sockets, public BasicRobotClient<Limits> {
public:
    /// With `packets`, all that it says and hears is protected.
    BasicSocketClient(boost::asio::io_context& io, const BrokerAddress& broker,
                      const client::Timing& timing, std::uint64_t seed,
                      typename BasicRobotClient<Limits>::OnEvent on_event,
                      std::shared_ptr<keys::ClientPackets> packets = nullptr)
        : Sockets(io, std::move(packets)),
          BasicRobotClient<Limits>(static_cast<Surroundings&>(*this), broker, timing, seed,
                                   std::move(on_event)) {}
};

using SocketClient = BasicSocketClient<SocketLimits>;
/// Of 8 MB: not one that many are made of, nor one for the stack.
using WatcherClient = BasicSocketClient<WatcherLimits>;

/// Looks `host` up: a name, an IPv4 or an IPv6 address. Throws std::runtime_error with a sentence.
[[nodiscard]] BrokerAddress resolve_broker(boost::asio::io_context& io, const std::string& host,
                                           std::uint16_t port);

}  // namespace romano::experiments
