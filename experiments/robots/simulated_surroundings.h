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
    /// All that it opens is at the place `node`. The world lives longer.
    SimulatedSurroundings(sim::World& world, sim::Node node) : world_(world), node_(node) {}

    /// Of the port that is opened as the so-maniest, from 0.
    [[nodiscard]] static Endpoint address_of_port(std::uint32_t number);

    [[nodiscard]] Instant now() const override { return world_.now(); }
    /// `broker` is an IPv4 address.
    [[nodiscard]] std::unique_ptr<Port> open_port(const BrokerAddress& broker,
                                                  Port::OnDatagram on_datagram) override;
    [[nodiscard]] std::unique_ptr<Alarm> make_alarm(std::function<void()> on_ring) override;

private:
    sim::World& world_;
    sim::Node node_;
    std::uint32_t ports_ = 0;
};

/// The address of a broker of a simulated world, as clients write it.
[[nodiscard]] BrokerAddress simulated_broker_address(std::size_t broker);

}  // namespace romano::experiments
