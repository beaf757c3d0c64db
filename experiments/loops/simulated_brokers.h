// Brokers of a loop as cores in virtual time, with their robots on links of 1 to 1.25 ms each way,
// so that a round takes 4 to 5 ms.
#pragma once

#include <memory>

#include "experiments/loops/faulty_brokers.h"
#include "experiments/robots/simulated_surroundings.h"
#include "overlay/sim/cluster_world.h"
#include "overlay/sim/lone_world.h"

namespace romano::experiments {

class SimulatedBrokers : public FaultyBrokers {
public:
    /// One seed is one run.
    SimulatedBrokers(std::uint64_t seed, std::size_t brokers);

    [[nodiscard]] Surroundings& surroundings() override { return *robots_; }
    [[nodiscard]] BrokerAddress address_of(std::size_t broker) const override {
        return simulated_broker_address(broker);
    }
    void run_for(Duration duration) override { world_->run_for(duration); }
    bool run_until(const std::function<bool()>& condition, Duration limit) override {
        return world_->run_until(condition, limit);
    }

protected:
    [[nodiscard]] sim::World& world() { return *world_; }
    void crash() override { struck_->crash(); }
    void start_again() override { struck_->start(); }
    void stop() override { struck_->stop(); }
    void go_on() override { struck_->go_on(); }
    void after(Duration delay, std::function<void()> action) override {
        world_->events().after(delay, std::move(action));
    }

private:
    std::unique_ptr<sim::LoneWorld> lone_;  // one of these two
    std::unique_ptr<sim::ClusterWorld> cluster_;
    sim::World* world_ = nullptr;
    sim::BrokerProcess* struck_ = nullptr;
    std::unique_ptr<SimulatedSurroundings> robots_;
};

}  // namespace romano::experiments
