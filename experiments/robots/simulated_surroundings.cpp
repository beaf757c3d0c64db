#include "experiments/robots/simulated_surroundings.h"

#include <algorithm>
#include <utility>

#include "broker/net/asio_endpoint.h"

namespace romano::experiments {
namespace {

class SimulatedPort final : public Port {
public:
    SimulatedPort(sim::ClientNetwork& network, sim::Node node, const Endpoint& own,
                  const Endpoint& broker, OnDatagram on_datagram)
        : network_(network), node_(node), own_(own), broker_(broker) {
        binding_ = network_.bind(
            own_, node_,
            [to = std::move(on_datagram)](const Endpoint&, const Endpoint&, Bytes datagram) {
                to(datagram);
            },
            [this](const Endpoint& from) { return from == broker_; });
    }
    ~SimulatedPort() override { network_.unbind(binding_); }

    void send(Bytes datagram) override { network_.send(node_, own_, broker_, datagram); }
    void talk_to(const BrokerAddress& broker) override { broker_ = net::to_endpoint(broker); }
    [[nodiscard]] bool was_refused() const override { return false; }

private:
    sim::ClientNetwork& network_;
    sim::Node node_;
    Endpoint own_;
    Endpoint broker_;
    sim::ClientNetwork::Binding binding_{};
};

/// What stands in the queue cannot be taken back: a wish that was put off is waited for once more,
/// and who is gone is not woken.
class SimulatedAlarm final : public Alarm {
public:
    SimulatedAlarm(sim::EventQueue& events, std::function<void()> on_ring)
        : wish_(std::make_shared<Wish>(events, std::move(on_ring))) {}

    void set(Instant when) override {
        wish_->when = when;
        if (when < wish_->queued_for) queue(wish_);
    }

private:
    struct Wish {
        Wish(sim::EventQueue& queue, std::function<void()> ring)
            : events(queue), on_ring(std::move(ring)) {}
        sim::EventQueue& events;
        std::function<void()> on_ring;
        Instant when = never;
        Instant queued_for = never;
    };

    static void queue(const std::shared_ptr<Wish>& wish) {
        const Instant at = std::max(wish->when, wish->events.now());
        wish->queued_for = at;
        wish->events.at(at, [at, weak = std::weak_ptr<Wish>(wish)] {
            const auto alive = weak.lock();
            if (!alive || alive->queued_for != at) return;
            alive->queued_for = never;
            if (alive->when == never) return;
            if (alive->when > at) return queue(alive);
            alive->when = never;
            alive->on_ring();
        });
    }

    std::shared_ptr<Wish> wish_;
};

}  // namespace

Endpoint SimulatedSurroundings::address_of_port(std::uint32_t number, std::uint8_t network) {
    Endpoint own{.port = 5'000, .family = Endpoint::Family::ipv4};
    own.address = {10, static_cast<std::uint8_t>(network + number / 62'500),
                   static_cast<std::uint8_t>(number / 250 % 250),
                   static_cast<std::uint8_t>(number % 250 + 1)};
    return own;
}

std::unique_ptr<Port> SimulatedSurroundings::open_port(const BrokerAddress& broker,
                                                       const std::string& /*client_id*/,
                                                       Port::OnDatagram on_datagram) {
    return std::make_unique<SimulatedPort>(world_.clients(), node_,
                                           address_of_port(ports_++, network_),
                                           net::to_endpoint(broker), std::move(on_datagram));
}

std::unique_ptr<Alarm> SimulatedSurroundings::make_alarm(std::function<void()> on_ring) {
    return std::make_unique<SimulatedAlarm>(world_.events(), std::move(on_ring));
}

BrokerAddress simulated_broker_address(std::size_t broker) {
    return net::to_asio<boost::asio::ip::udp>(sim::World::service_address(broker));
}

}  // namespace romano::experiments
