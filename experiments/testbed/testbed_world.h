// Brokers on the machines of a testbed, robots on this one: one clock times both ends of a
// delivery. What is done to a broker is told to its machine's romano-host through ssh, and arrives
// as much later as that takes.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiments/robots/sockets.h"
#include "experiments/sweep/real_time_world.h"
#include "experiments/sweep/sweep_file.h"
#include "experiments/testbed/host_channel.h"
#include "experiments/testbed/testbed_place.h"

namespace romano::experiments {

class TestbedWorld final : public RealTimeWorld {
public:
    /// Throws RunFailed when a machine that the cell needs is not there.
    TestbedWorld(const SweepSettings& settings, const Cell& cell, const TestbedPlace& place);

    [[nodiscard]] Surroundings& surroundings() override { return robots_; }

    [[nodiscard]] BrokerAddress address_of(std::size_t broker) const override;
    void start(std::size_t broker, const BrokerLife& life) override;
    void kill(std::size_t broker) override;
    void ask_to_stop(std::size_t broker) override;
    void pause(std::size_t broker) override;
    void resume(std::size_t broker) override;
    /// Of all brokers on that machine.
    void cut(std::size_t broker) override;
    void mend(std::size_t broker) override;
    /// What they have printed, and their last metrics, are in the results when it returns. A
    /// machine whose cable was pulled in the cell's last seconds is missed here.
    void stop_all() override;

    /// Throws RunFailed when its machine is gone.
    [[nodiscard]] bool has_ended(std::size_t broker) override;
    [[nodiscard]] std::string how_it_ended(std::size_t broker) const override;
    /// As of the last tenth of a second.
    [[nodiscard]] std::optional<ProcessUsage> usage_of(std::size_t broker) const override;

private:
    struct Machine {
        const Host* host = nullptr;
        std::unique_ptr<HostChannel> channel;
        bool has_stopped = false;
        std::string trouble;  // what it told
    };
    struct Broker {
        Seat seat;
        std::uint32_t lives = 0;
        std::optional<std::string> how_it_ended;
        std::optional<ProcessUsage> usage;
    };

    void open(const TestbedPlace& place, std::size_t host);
    void await_begin(const Ssh& ssh, Machine& machine);
    /// Throws RunFailed when it is gone.
    static void check_presence(const Machine& machine);
    [[nodiscard]] Machine& machine_of(std::size_t broker) {
        return machines_.at(brokers_[broker].seat.host);
    }
    void tell(std::size_t broker, const char* what);
    void hear(Machine& machine, const nlohmann::json& words);
    /// The broker of that number, if it is this life that is spoken of.
    [[nodiscard]] Broker* meant(const nlohmann::json& number, const nlohmann::json& life);
    void keep_files(const nlohmann::json& words);

    const SweepSettings& settings_;
    std::uint32_t domain_;
    Sockets robots_{io()};
    std::vector<Broker> brokers_;
    std::map<std::string, std::filesystem::path> traces_;  // by the names that machines know
    std::map<std::size_t, Machine> machines_;              // by the numbers of their hosts
};

}  // namespace romano::experiments
