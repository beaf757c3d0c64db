#include "experiments/robots/sockets.h"

#include <array>
#include <boost/asio/buffer.hpp>
#include <optional>
#include <utility>

#include "broker/net/clock.h"
#include "broker/net/core_timer.h"
#include "romano/keys/client_speech.h"
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
               std::shared_ptr<keys::ClientPackets> key)
        : socket_(io, broker.protocol()),
          on_datagram_(std::move(on_datagram)),
          key_(std::move(key)) {
        if (key_) {
            timer_.emplace(io, [this] {
                speech_->on_time();
                wake_when_due();
            });
        }
        talk_to(broker);
        socket_.non_blocking(true);
        receive();
    }

    void send(Bytes message) override {
        if (!speech_) return put(message);
        speech_->send(message);
        wake_when_due();
    }
    /// The kernel keeps a socket's own address and port when it is connected again.
    void talk_to(const BrokerAddress& broker) override {
        speech_.reset();  // may say goodbye to the one before
        socket_.connect(broker);
        if (key_) speech_ = keys::speak(key_, [this](Bytes datagram) { put(datagram); });
    }
    [[nodiscard]] bool was_refused() const override { return was_refused_; }
    [[nodiscard]] std::uint64_t handshakes() const override {
        return speech_ ? speech_->handshakes() : 0;
    }

private:
    void put(Bytes datagram) {
        boost::system::error_code lost;
        socket_.send(boost::asio::buffer(datagram.data(), datagram.size()), 0, lost);
        if (lost == boost::asio::error::connection_refused) {
            // The error of an earlier datagram; this one was not sent.
            was_refused_ = true;
            socket_.send(boost::asio::buffer(datagram.data(), datagram.size()), 0, lost);
        }
    }

    void wake_when_due() {
        if (const auto due = speech_->due_in()) timer_->arm(net::now() + *due);
    }

    void hear(Bytes datagram) {
        if (!speech_) return on_datagram_(datagram);
        const Bytes message = speech_->open(datagram);
        if (!message.empty()) on_datagram_(message);  // else it is forged, old, or a handshake's
    }

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
                    hear({buffer.data(), size});
                }
                if (speech_) wake_when_due();
                receive();
            });
    }

    udp::socket socket_;
    OnDatagram on_datagram_;
    std::shared_ptr<keys::ClientPackets> key_;    // null: plain
    std::unique_ptr<keys::ClientSpeech> speech_;  // with the key
    std::optional<net::CoreTimer> timer_;         // of the speech
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
                                         const std::string& /*client_id*/,
                                         Port::OnDatagram on_datagram) {
    return open_socket(broker, std::move(on_datagram), packets_);
}

std::unique_ptr<Port> Sockets::open_socket(const BrokerAddress& broker,
                                           Port::OnDatagram on_datagram,
                                           std::shared_ptr<keys::ClientPackets> packets) {
    return std::make_unique<SocketPort>(io_, broker, std::move(on_datagram), std::move(packets));
}

std::unique_ptr<Alarm> Sockets::make_alarm(std::function<void()> on_ring) {
    return std::make_unique<SocketAlarm>(io_, std::move(on_ring));
}

}  // namespace romano::experiments
