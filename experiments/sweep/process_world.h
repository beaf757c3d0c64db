// Real brokers as processes, and robots on real sockets, in real time.
//
// The brokers share this machine's loopback network; where the cell cuts networks, each is on a
// machine of its own (process/lan.h), and the robots on another.
#pragma once

#include <memory>

#include "experiments/process/broker_process.h"
#include "experiments/process/lan.h"
#include "experiments/robots/sockets.h"
#include "experiments/sweep/cell_keys.h"
#include "experiments/sweep/place.h"
#include "experiments/sweep/real_time_world.h"
#include "experiments/sweep/sweep_file.h"

namespace romano::experiments {

class ProcessWorld : public RealTimeWorld {
public:
    /// `network` is the sweep's own, such as "127.50". Throws RunFailed.
    ProcessWorld(const SweepSettings& settings, const Cell& cell, const std::string& network,
                 std::filesystem::path program);

    [[nodiscard]] Surroundings& surroundings() override { return robots_; }
    [[nodiscard]] BrokerAddress address_of(std::size_t broker) const override;
    void start(std::size_t broker, const BrokerLife& life) override;
    void kill(std::size_t broker) override { brokers_[broker]->kill(); }
    void ask_to_stop(std::size_t broker) override { brokers_[broker]->ask_to_stop(); }
    void pause(std::size_t broker) override { brokers_[broker]->pause(); }
    void resume(std::size_t broker) override { brokers_[broker]->resume(); }
    void cut(std::size_t broker) override { lan_->cut(host_of(broker)); }
    void mend(std::size_t broker) override { lan_->mend(host_of(broker)); }
    void stop_all() override;

    [[nodiscard]] bool has_ended(std::size_t broker) override {
        return brokers_[broker]->has_ended();
    }
    [[nodiscard]] std::string how_it_ended(std::size_t broker) const override {
        return brokers_[broker]->how_it_ended();
    }
    [[nodiscard]] std::optional<ProcessUsage> usage_of(std::size_t broker) const override;

private:
    /// On the robots' machine, if there is one; with keys, if there are some.
    class RobotSockets final : public Sockets {
    public:
        RobotSockets(ProcessWorld& world, boost::asio::io_context& io)
            : Sockets(io), world_(world) {}
        [[nodiscard]] std::unique_ptr<Port> open_port(const BrokerAddress& broker,
                                                      const std::string& client_id,
                                                      Port::OnDatagram on_datagram) override;

    private:
        ProcessWorld& world_;
    };

    [[nodiscard]] static int host_of(std::size_t broker) { return static_cast<int>(broker) + 1; }

    std::uint16_t port_;
    std::string subnet_;  // of the brokers' addresses: "127.50.2."
    std::filesystem::path program_;
    RobotSockets robots_{*this, io()};
    std::optional<CellKeys> keys_;
    std::optional<DomainPlace> domain_;  // one broker needs none
    std::optional<Lan> lan_;
    std::vector<std::unique_ptr<BrokerProcess>> brokers_;
};

}  // namespace romano::experiments
