// Brokers of a loop as processes on this machine, with their robots on its sockets, in real time.
#pragma once

#include <filesystem>
#include <memory>

#include "experiments/loops/faulty_brokers.h"
#include "experiments/sweep/cell_brokers.h"
#include "experiments/sweep/place.h"
#include "experiments/sweep/process_world.h"

namespace romano::experiments {

class RealBrokers final : public FaultyBrokers {
public:
    /// Throws std::runtime_error when they are not in one view in time, and from any run when one
    /// ends by itself.
    RealBrokers(const std::filesystem::path& program, std::size_t brokers,
                const std::filesystem::path& traces);
    ~RealBrokers() override;

    [[nodiscard]] Surroundings& surroundings() override { return world_.surroundings(); }
    [[nodiscard]] BrokerAddress address_of(std::size_t broker) const override {
        return world_.address_of(broker);
    }
    void run_for(Duration duration) override;
    bool run_until(const std::function<bool()>& condition, Duration limit) override;

private:
    void crash() override { brokers_.kill(0); }
    void start_again() override { brokers_.start(0); }
    void stop() override { world_.pause(0); }
    void go_on() override { world_.resume(0); }
    void after(Duration delay, std::function<void()> action) override;

    NetworkPlace place_;
    SweepSettings settings_;
    Cell cell_;
    ProcessWorld world_;
    std::unique_ptr<Alarm> alarm_;
    CellBrokers brokers_;
};

}  // namespace romano::experiments
