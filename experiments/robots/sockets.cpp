#include "experiments/robots/sockets.h"

#include <array>
#include <boost/asio/buffer.hpp>
#include <utility>

#include "broker/net/clock.h"
#include "broker/net/core_timer.h"
#include "romano/mqttsn/codec.h"

namespace romano::experiments {
namespace {

using boost::asio::ip::udp;

/// All sockets of one thread share it: it is used between a datagram and its handling only.
std::array<std::uint8_t, mqttsn::max_datagram>& shared_buffer() {
    thread_local std::array<std::uint8_t, mqttsn::max_datagram> buffer;
    return buffer;
}

class SocketPort final : public Port {
public:
    SocketPort(boost::asio::io_context& io, const BrokerAddress& broker, OnDatagram on_datagram,
               std::shared_ptr<keys::ClientPackets> packets)
        : socket_(io, broker.protocol()),
          on_datagram_(std::move(on_datagram)),
          packets_(std::move(packets)) {
        socket_.connect(broker);
        socket_.non_blocking(true);
        receive();
    }

    void send(Bytes message) override {
        const Bytes datagram = packets_ ? packets_->seal(message) : message;
        if (datagram.empty()) return;  // no number is left
        boost::system::error_code lost;
        socket_.send(boost::asio::buffer(datagram.data(), datagram.size()), 0, lost);
        if (lost == boost::asio::error::connection_refused) {
            // The error of an earlier datagram; this one was not sent.
            was_refused_ = true;
            socket_.send(boost::asio::buffer(datagram.data(), datagram.size()), 0, lost);
        }
    }
    /// The kernel keeps a socket's own address and port when it is connected again.
    void talk_to(const BrokerAddress& broker) override { socket_.connect(broker); }
    [[nodiscard]] bool was_refused() const override { return was_refused_; }

private:
    void receive() {
        socket_.async_wait(
            udp::socket::wait_read, [this](const boost::system::error_code& stopped) {
                if (stopped) return;
                auto& buffer = shared_buffer();
                // A burst at most, so that a flooded client lets the others have their turn.
                for (int burst = 0; burst < 32; ++burst) {
                    boost::system::error_code error;
                    const std::size_t size = socket_.receive(boost::asio::buffer(buffer), 0, error);
                    if (error == boost::asio::error::connection_refused) {
                        was_refused_ = true;
                        continue;
                    }
                    if (error) break;
                    Bytes message{buffer.data(), size};
                    if (packets_) message = packets_->open({buffer.data(), size});
                    if (packets_ && message.empty()) continue;  // forged, old, or not for us
                    on_datagram_(message);
                }
                receive();
            });
    }

    udp::socket socket_;
    OnDatagram on_datagram_;
    std::shared_ptr<keys::ClientPackets> packets_;  // null: plain
    bool was_refused_ = false;
};

/// A core's timer wakes early when a wish was put off: no system call for each datagram.
class SocketAlarm final : public Alarm {
public:
    SocketAlarm(boost::asio::io_context& io, std::function<void()> on_ring)
        : on_ring_(std::move(on_ring)), timer_(io, [this] { on_wakeup(); }) {}

    void set(Instant when) override {
        when_ = when;
        timer_.arm(when_);
    }

private:
    void on_wakeup() {
        if (net::now() < when_) return timer_.arm(when_);
        when_ = never;
        on_ring_();
    }

    std::function<void()> on_ring_;
    Instant when_ = never;
    net::CoreTimer timer_;
};

}  // namespace

Instant Sockets::now() const {
    return net::now();
}

std::unique_ptr<Port> Sockets::open_port(const BrokerAddress& broker,
                                         Port::OnDatagram on_datagram) {
    return std::make_unique<SocketPort>(io_, broker, std::move(on_datagram), packets_);
}

std::unique_ptr<Alarm> Sockets::make_alarm(std::function<void()> on_ring) {
    return std::make_unique<SocketAlarm>(io_, std::move(on_ring));
}

}  // namespace romano::experiments
