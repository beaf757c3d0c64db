// Where everything happens: virtual time, the trace, the network of the clients, the robots and
// what they saw. The brokers come with lone_world.h or cluster_world.h.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "overlay/sim/client_network.h"
#include "overlay/sim/event_queue.h"
#include "overlay/sim/ledger.h"
#include "overlay/sim/link.h"
#include "overlay/sim/robot.h"
#include "overlay/sim/trace.h"

namespace romano::sim {

class World {
public:
    explicit World(std::uint64_t seed);
    World(const World&) = delete;
    World& operator=(const World&) = delete;

    /// Fills in the robot's own address and node, and the broker's address, unless given. Call
    /// start() on it when it shall begin.
    Robot& add_robot(RobotOptions options);

    void run_for(Duration duration) { events_.run_for(duration); }
    /// True as soon as `condition` holds; looked at every `step`.
    bool run_until(const std::function<bool()>& condition, Duration limit,
                   Duration step = std::chrono::milliseconds{10});

    [[nodiscard]] Instant now() const { return events_.now(); }
    [[nodiscard]] std::uint64_t seed() const { return seed_; }
    [[nodiscard]] EventQueue& events() { return events_; }
    [[nodiscard]] Trace& trace() { return trace_; }
    [[nodiscard]] ClientNetwork& clients() { return clients_; }
    [[nodiscard]] const Ledger& ledger() const { return ledger_; }
    [[nodiscard]] Robot& robot(std::size_t index) { return *robots_.at(index); }
    [[nodiscard]] std::size_t robot_count() const { return robots_.size(); }
    /// All that are on are connected and wait for nothing.
    [[nodiscard]] bool robots_are_idle() const;

    /// 10.0.1.1:1883, 10.0.1.2:1883, ...: the home address of each broker.
    [[nodiscard]] static Endpoint service_address(std::size_t broker);
    /// Of each broker's cell; whose it is tells the sender's address.
    [[nodiscard]] static Endpoint cell_group();
    [[nodiscard]] static Node broker_node(std::size_t broker) {
        return Node{static_cast<std::uint32_t>(broker)};
    }

private:
    static constexpr std::uint32_t first_robot_node = 1'000;

    std::uint64_t seed_;
    EventQueue events_;
    Trace trace_;
    ClientNetwork clients_;
    Ledger ledger_;
    std::vector<std::unique_ptr<Robot>> robots_;
};

}  // namespace romano::sim
