#include "experiments/sweep/air_world.h"

#include <algorithm>
#include <boost/system/system_error.hpp>
#include <optional>
#include <utility>

#include "broker/net/asio_endpoint.h"
#include "experiments/air/radio_bridge.h"
#include "experiments/sweep/baud.h"
#include "experiments/sweep/process_world.h"

namespace romano::experiments {
namespace {

/// Beside its broker's address: 127.50.2.129 for 127.50.2.1.
BrokerAddress router_of(const BrokerAddress& broker) {
    constexpr std::uint32_t beside = 128;
    const boost::asio::ip::address_v4 address{broker.address().to_v4().to_uint() + beside};
    return {address, broker.port()};
}

RadioBridgeOptions bridge_of(const SweepSettings& settings, const Cell& cell,
                             const std::vector<BrokerAddress>& brokers) {
    RadioBridgeOptions options;
    for (const BrokerAddress& broker : brokers) {
        options.cells.push_back({net::to_endpoint(router_of(broker)), net::to_endpoint(broker)});
    }
    options.robots = (cell.robots + cell.brokers - 1) / cell.brokers;
    options.channels = settings.radio.channels;
    options.router_baud = baud_of(cell.router_baud);
    options.robot_baud = baud_of(cell.robot_baud);
    options.router_distance_m = settings.radio.router_distance_m;
    options.seed = cell.seed;
    return options;
}

class AirWorld final : public ProcessWorld {
public:
    AirWorld(const SweepSettings& settings, const Cell& cell, const std::string& network,
             std::filesystem::path program)
        : ProcessWorld(settings, cell, network, std::move(program)) {
        std::vector<BrokerAddress> brokers;
        for (std::size_t i = 0; i < cell.brokers; ++i) brokers.push_back(address_of(i));
        try {
            bridge_.emplace(io(), bridge_of(settings, cell, brokers), [] {});
        } catch (const boost::system::system_error& error) {
            throw RunFailed("no border routers: " + error.code().message());
        }
    }

    [[nodiscard]] Surroundings& robots() override { return on_air_; }

    void check_measured() override {
        const RadioBridgeFigures figures = bridge_->figures();
        if (!figures.has_lagged()) return;
        throw RunFailed(std::to_string(figures.late) + " of " +
                        std::to_string(figures.lag.count()) +
                        " datagrams came late from the channel: this machine was too busy for it");
    }

private:
    /// Robots talk to the router of their broker as to the broker.
    class OnAir final : public Sockets {
    public:
        using Sockets::Sockets;
        [[nodiscard]] std::unique_ptr<Port> open_port(const BrokerAddress& broker,
                                                      const std::string&,
                                                      Port::OnDatagram on_datagram) override {
            return open_socket(router_of(broker), std::move(on_datagram), nullptr);
        }
    };

    OnAir on_air_{io()};
    std::optional<RadioBridge> bridge_;
};

}  // namespace

void check_air(const SweepSettings& settings, const std::vector<Cell>& cells) {
    constexpr std::size_t most_robots = 200;  // to a router, in real time
    for (const Cell& cell : cells) {
        const RadioBridgeOptions options =
            bridge_of(settings, cell,
                      std::vector<BrokerAddress>(
                          cell.brokers, {boost::asio::ip::address_v4::loopback(), settings.port}));
        if (options.robots > most_robots) {
            throw SweepError("`world = \"air\"`: " + std::to_string(options.robots) +
                             " robots are too many for one cell in real time: at most " +
                             std::to_string(most_robots));
        }
        if (cell.fault == Fault::cut) {
            throw SweepError(
                "`world = \"air\"`: fault `cut` takes a broker's machine off the network, and here "
                "all are on one; take another fault, or `world = \"radio\"`");
        }
        if (const auto problem = problem_with(options)) {
            throw SweepError("`world = \"air\"`: " + *problem);
        }
    }
}

std::unique_ptr<CellWorld> make_air_world(const SweepSettings& settings, const Cell& cell,
                                          const std::string& network,
                                          const std::filesystem::path& program) {
    return std::make_unique<AirWorld>(settings, cell, network, program);
}

}  // namespace romano::experiments
