// Brokers and robots in virtual time: the shipped cores on overlay/sim, with links that delay and
// lose. One seed is one run.
//
// A broker is told what romano-broker is told, by the same command line, and runs with the settings
// that romano-broker would run with. It has no processor of its own: a step takes no time.
#pragma once

#include <memory>
#include <vector>

#include "experiments/robots/simulated_surroundings.h"
#include "experiments/sweep/cell_world.h"
#include "experiments/sweep/sweep_file.h"
#include "overlay/dds/body_codec.h"
#include "overlay/sim/broker_network.h"
#include "overlay/sim/broker_process.h"
#include "overlay/sim/world.h"
#include "romano/base/random.h"

namespace romano::experiments {

/// Throws SweepError for `broker_options` that are none, or mean nothing without a machine.
void check_simulated_broker_options(const SweepSettings& settings);

class SimulatedWorld : public CellWorld {
public:
    SimulatedWorld(const SweepSettings& settings, const Cell& cell);
    ~SimulatedWorld() override;

    [[nodiscard]] Surroundings& surroundings() override { return clients_; }
    [[nodiscard]] std::string date() const override { return {}; }
    bool run_until(Instant deadline, const std::function<bool()>& done,
                   const std::function<void()>& look) override;
    void finish_moment() override {}

    [[nodiscard]] BrokerAddress address_of(std::size_t broker) const override {
        return simulated_broker_address(broker);
    }
    void start(std::size_t broker, const BrokerLife& life) override;
    void kill(std::size_t broker) override;
    void ask_to_stop(std::size_t broker) override;
    void pause(std::size_t broker) override;
    void resume(std::size_t broker) override;
    void cut(std::size_t broker) override;
    void mend(std::size_t broker) override;
    void stop_all() override {}

    [[nodiscard]] bool has_ended(std::size_t broker) override;
    [[nodiscard]] std::string how_it_ended(std::size_t) const override { return "by itself"; }
    [[nodiscard]] std::optional<ProcessUsage> usage_of(std::size_t) const override { return {}; }

protected:
    /// All clients are at one place, as they are on one machine in the real world.
    static constexpr sim::Node clients_node{1'000'000};

    [[nodiscard]] sim::World& world() { return world_; }
    [[nodiscard]] sim::BrokerNetwork& peers() { return peers_; }

private:
    struct Broker {
        std::unique_ptr<sim::BrokerProcess> process;
        bool is_starting = false;
    };

    [[nodiscard]] std::unique_ptr<sim::BrokerProcess> make_broker(std::size_t broker,
                                                                  const BrokerLife& life);

    dds::BodyCodec codec_;  // says how large messages between brokers are
    sim::World world_;
    sim::BrokerNetwork peers_;
    Random random_;
    SimulatedSurroundings clients_;
    std::vector<Broker> brokers_;
};

}  // namespace romano::experiments
