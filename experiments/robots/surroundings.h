// What a client needs of the world around it: the time, a port towards its broker, and somebody who
// wakes it. Real sockets and the machine's clock are one world (sockets.h), a simulated one is
// another (simulated_surroundings.h); the clients are the same.
#pragma once

#include <boost/asio/ip/udp.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "romano/base/bytes.h"
#include "romano/base/time.h"

namespace romano::experiments {

using BrokerAddress = boost::asio::ip::udp::endpoint;

/// Talks to one broker address and hears nobody else.
class Port {
public:
    using OnDatagram = std::function<void(Bytes datagram)>;

    Port() = default;
    virtual ~Port() = default;
    Port(const Port&) = delete;
    Port& operator=(const Port&) = delete;

    /// What it cannot take is lost, as on any network.
    virtual void send(Bytes datagram) = 0;
    /// With another one from now on, from the same address of its own.
    virtual void talk_to(const BrokerAddress& broker) = 0;
    /// It was told that nobody listens at the broker's address.
    [[nodiscard]] virtual bool was_refused() const = 0;
    /// Of DTLS, that it has begun.
    [[nodiscard]] virtual std::uint64_t handshakes() const { return 0; }
};

class Alarm {
public:
    Alarm() = default;
    virtual ~Alarm() = default;
    Alarm(const Alarm&) = delete;
    Alarm& operator=(const Alarm&) = delete;

    /// Rings once, not before `when`; an earlier wish is forgotten. `never`: not at all.
    virtual void set(Instant when) = 0;
};

class Surroundings {
public:
    Surroundings() = default;
    virtual ~Surroundings() = default;
    Surroundings(const Surroundings&) = delete;
    Surroundings& operator=(const Surroundings&) = delete;

    [[nodiscard]] virtual Instant now() const = 0;
    /// Ports and alarms do not outlive their surroundings. `client_id` is of whoever speaks there,
    /// and matters where each client has a key of its own.
    [[nodiscard]] virtual std::unique_ptr<Port> open_port(const BrokerAddress& broker,
                                                          const std::string& client_id,
                                                          Port::OnDatagram on_datagram) = 0;
    [[nodiscard]] virtual std::unique_ptr<Alarm> make_alarm(std::function<void()> on_ring) = 0;
};

}  // namespace romano::experiments
