#include "experiments/robots/robot_client.h"

#include <utility>

namespace romano::experiments {
namespace {

/// All clients of one thread share it: it is used between an input and its drain only.
template <typename Limits>
client::OutputFor<Limits>& shared_output() {
    thread_local client::OutputFor<Limits> output;
    return output;
}

}  // namespace

void SentCounts::count(Bytes datagram) {
    // Section 5.2.1: a first octet of 1 announces a length of three octets.
    const std::size_t type_at = !datagram.empty() && datagram[0] == 0x01 ? 3 : 1;
    if (type_at < datagram.size()) ++counts_[datagram[type_at]];
}

template <typename Limits>
BasicRobotClient<Limits>::BasicRobotClient(Surroundings& surroundings, const BrokerAddress& broker,
                                           const client::Timing& timing, std::uint64_t seed,
                                           OnEvent on_event, const std::string& client_id)
    : surroundings_(surroundings),
      core_(timing, seed),
      on_event_(std::move(on_event)),
      alarm_(surroundings.make_alarm([this] {
          core_.on_tick(surroundings_.now(), shared_output<Limits>());
          drain();
      })),
      port_(surroundings.open_port(broker, client_id, [this](Bytes datagram) {
          core_.on_datagram(surroundings_.now(), datagram, shared_output<Limits>());
          drain();
      })) {}

template <typename Limits>
void BasicRobotClient<Limits>::connect(const client::ConnectOptions& options) {
    core_.connect(surroundings_.now(), options, shared_output<Limits>());
    drain();
}

template <typename Limits>
void BasicRobotClient<Limits>::disconnect() {
    core_.disconnect(surroundings_.now(), shared_output<Limits>());
    drain();
}

template <typename Limits>
typename BasicRobotClient<Limits>::Begun BasicRobotClient<Limits>::publish(
    const mqttsn::TopicRef& topic, Bytes data, const client::PublishOptions& options) {
    const Begun begun =
        core_.publish(surroundings_.now(), topic, data, options, shared_output<Limits>());
    drain();
    return begun;
}

template <typename Limits>
typename BasicRobotClient<Limits>::Begun BasicRobotClient<Limits>::subscribe(
    const mqttsn::TopicRef& topic, mqttsn::Qos qos) {
    const Begun begun = core_.subscribe(surroundings_.now(), topic, qos, shared_output<Limits>());
    drain();
    return begun;
}

template <typename Limits>
typename BasicRobotClient<Limits>::Begun BasicRobotClient<Limits>::register_name(
    std::string_view name) {
    const Begun begun = core_.register_name(surroundings_.now(), name, shared_output<Limits>());
    drain();
    return begun;
}

template <typename Limits>
void BasicRobotClient<Limits>::probe() {
    core_.probe(surroundings_.now());
    core_.on_tick(surroundings_.now(), shared_output<Limits>());
    drain();
}

template <typename Limits>
void BasicRobotClient<Limits>::drain() {
    const auto& output = shared_output<Limits>();
    for (const Bytes datagram : output.datagrams()) {
        sent_.count(datagram);
        port_->send(datagram);
    }
    alarm_->set(core_.next_wakeup());
    // An event's owner may call back into this client, which empties the shared output.
    std::array<client::Event, client::Output::most> events;
    const std::size_t count = output.events().size();
    for (std::size_t i = 0; i < count; ++i) events[i] = output.events()[i];
    for (std::size_t i = 0; i < count; ++i) on_event_(events[i]);
}

template class BasicRobotClient<SocketLimits>;
template class BasicRobotClient<WatcherLimits>;

}  // namespace romano::experiments
