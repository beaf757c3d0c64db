// A simulated world as clients see it: ports on its clients' network, alarms in virtual time.
#pragma once

#include <cstdint>
#include <memory>

#include "experiments/robots/surroundings.h"
#include "overlay/sim/world.h"
#include "romano/base/endpoint.h"

namespace romano::experiments {

class SimulatedSurroundings final : public Surroundings {
public:
    /// The ports have addresses in 10.2.0.0/16, and in the networks behind it when there are many.
    static constexpr std::uint8_t usual_network = 2;

    /// All that it opens is at the place `node`. The world lives longer. Two of one world have
    /// networks far from each other.
    SimulatedSurroundings(sim::World& world, sim::Node node, std::uint8_t network = usual_network)
        : world_(world), node_(node), network_(network) {}

    /// Of the port that is opened as the so-maniest, from 0.
    [[nodiscard]] static Endpoint address_of_port(std::uint32_t number,
                                                  std::uint8_t network = usual_network);

    [[nodiscard]] Instant now() const override { return world_.now(); }
    /// `broker` is an IPv4 address.
    [[nodiscard]] std::unique_ptr<Port> open_port(const BrokerAddress& broker,
                                                  const std::string& client_id,
                                                  Port::OnDatagram on_datagram) override;
    [[nodiscard]] std::unique_ptr<Alarm> make_alarm(std::function<void()> on_ring) override;

private:
    sim::World& world_;
    sim::Node node_;
    std::uint8_t network_;
    std::uint32_t ports_ = 0;
};

/// The address of a broker of a simulated world, as clients write it.
[[nodiscard]] BrokerAddress simulated_broker_address(std::size_t broker);

}  // namespace romano::experiments
