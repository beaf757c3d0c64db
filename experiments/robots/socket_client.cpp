#include "experiments/robots/socket_client.h"

#include <boost/asio/buffer.hpp>
#include <stdexcept>
#include <utility>

#include "broker/net/clock.h"

namespace romano::experiments {
namespace {

using boost::asio::ip::udp;

/// All clients of one thread share these: they are used between an input and its drain only.
template <typename Limits>
client::OutputFor<Limits>& shared_output() {
    thread_local client::OutputFor<Limits> output;
    return output;
}

std::array<std::uint8_t, mqttsn::max_datagram>& shared_buffer() {
    thread_local std::array<std::uint8_t, mqttsn::max_datagram> buffer;
    return buffer;
}

}  // namespace

void SentCounts::count(Bytes datagram) {
    // Section 5.2.1: a first octet of 1 announces a length of three octets.
    const std::size_t type_at = !datagram.empty() && datagram[0] == 0x01 ? 3 : 1;
    if (type_at < datagram.size()) ++counts_[datagram[type_at]];
}

template <typename Limits>
BasicSocketClient<Limits>::BasicSocketClient(boost::asio::io_context& io,
                                             const BrokerAddress& broker,
                                             const client::Timing& timing, std::uint64_t seed,
                                             OnEvent on_event,
                                             std::shared_ptr<keys::ClientPackets> packets)
    : socket_(io, broker.protocol()),
      core_(timing, seed),
      on_event_(std::move(on_event)),
      packets_(std::move(packets)),
      timer_(io, [this] { tick(); }) {
    socket_.connect(broker);
    socket_.non_blocking(true);
    receive();
}

template <typename Limits>
void BasicSocketClient<Limits>::connect(const client::ConnectOptions& options) {
    core_.connect(net::now(), options, shared_output<Limits>());
    drain();
}

template <typename Limits>
void BasicSocketClient<Limits>::disconnect() {
    core_.disconnect(net::now(), shared_output<Limits>());
    drain();
}

template <typename Limits>
typename BasicSocketClient<Limits>::Begun BasicSocketClient<Limits>::publish(
    const mqttsn::TopicRef& topic, Bytes data, const client::PublishOptions& options) {
    const Begun begun = core_.publish(net::now(), topic, data, options, shared_output<Limits>());
    drain();
    return begun;
}

template <typename Limits>
typename BasicSocketClient<Limits>::Begun BasicSocketClient<Limits>::subscribe(
    const mqttsn::TopicRef& topic, mqttsn::Qos qos) {
    const Begun begun = core_.subscribe(net::now(), topic, qos, shared_output<Limits>());
    drain();
    return begun;
}

template <typename Limits>
typename BasicSocketClient<Limits>::Begun BasicSocketClient<Limits>::register_name(
    std::string_view name) {
    const Begun begun = core_.register_name(net::now(), name, shared_output<Limits>());
    drain();
    return begun;
}

template <typename Limits>
void BasicSocketClient<Limits>::probe() {
    core_.probe(net::now());
    tick();
}

template <typename Limits>
void BasicSocketClient<Limits>::receive() {
    socket_.async_wait(udp::socket::wait_read, [this](const boost::system::error_code& stopped) {
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
            core_.on_datagram(net::now(), message, shared_output<Limits>());
            drain();
        }
        receive();
    });
}

template <typename Limits>
void BasicSocketClient<Limits>::drain() {
    const auto& output = shared_output<Limits>();
    for (const Bytes message : output.datagrams()) {
        sent_.count(message);
        const Bytes datagram = packets_ ? packets_->seal(message) : message;
        if (datagram.empty()) continue;  // no number is left
        // What the socket does not take is lost, as on any network; the core repeats it.
        boost::system::error_code lost;
        socket_.send(boost::asio::buffer(datagram.data(), datagram.size()), 0, lost);
        if (lost == boost::asio::error::connection_refused) {
            // The error of an earlier datagram; this one was not sent.
            was_refused_ = true;
            socket_.send(boost::asio::buffer(datagram.data(), datagram.size()), 0, lost);
        }
    }
    timer_.arm(core_.next_wakeup());
    // An event's owner may call back into this client, which empties the shared output.
    std::array<client::Event, client::Output::most> events;
    const std::size_t count = output.events().size();
    for (std::size_t i = 0; i < count; ++i) events[i] = output.events()[i];
    for (std::size_t i = 0; i < count; ++i) on_event_(events[i]);
}

template <typename Limits>
void BasicSocketClient<Limits>::tick() {
    core_.on_tick(net::now(), shared_output<Limits>());
    drain();
}

template class BasicSocketClient<SocketLimits>;
template class BasicSocketClient<WatcherLimits>;

BrokerAddress resolve_broker(boost::asio::io_context& io, const std::string& host,
                             std::uint16_t port) {
    boost::system::error_code error;
    udp::resolver resolver(io);
    const auto found =
        resolver.resolve(host, std::to_string(port), udp::resolver::numeric_service, error);
    if (error || found.empty()) {
        throw std::runtime_error("cannot find the host `" + host + "`: " + error.message());
    }
    return found.begin()->endpoint();
}

}  // namespace romano::experiments
