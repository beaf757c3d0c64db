// The brokers of a loop, and what befalls the one that its robots talk to: one broker alone, or a
// cluster with the times of profile `lan` and with links (overlay/link).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "overlay/sim/cluster_world.h"
#include "overlay/sim/lone_world.h"

namespace romano::experiments {

enum class BrokerFault : std::uint8_t {
    none,
    crash_for_good,  // kill -9
    crash,           // kill -9, and its service starts it again a second later
    silence,         // SIGSTOP, and SIGCONT a second later
    roaming,         // nothing: its robots drive on to the next broker
};
[[nodiscard]] std::string_view name_of(BrokerFault fault);

struct Kind {
    std::size_t brokers;
    BrokerFault fault;
};
/// What can befall one of so many brokers, for each number; nothing comes first.
[[nodiscard]] std::vector<Kind> kinds_with(const std::vector<std::size_t>& brokers);
/// "1 broker", "3 brokers".
[[nodiscard]] std::string brokers_text(std::size_t brokers);

class FaultyBrokers {
public:
    /// RestartSec of broker/daemon/package/romano-broker.service, and as long a silence.
    static constexpr Duration back_after{std::chrono::seconds{1}};

    /// They serve when the constructor returns. Datagrams take from 1 to 1.25 ms each way, so that
    /// a round takes 4 to 5 ms.
    FaultyBrokers(std::uint64_t seed, std::size_t brokers);

    [[nodiscard]] sim::World& world() { return *world_; }
    /// Where all robots of the loops are at first.
    [[nodiscard]] static Endpoint first() { return sim::World::service_address(0); }
    /// Where they roam to.
    [[nodiscard]] static Endpoint second() { return sim::World::service_address(1); }

    /// Befalls the first broker now, and ends by itself. Roaming is the robots' part.
    void strike(BrokerFault fault);

private:
    std::unique_ptr<sim::LoneWorld> lone_;  // one of these two
    std::unique_ptr<sim::ClusterWorld> cluster_;
    sim::World* world_ = nullptr;
    sim::BrokerProcess* struck_ = nullptr;
};

/// README.md of romano/control, "How old a command can get": going on when a broker dies or falls
/// silent takes a deadline of F + 2 P + D, with F the detection time and D = 5 ms.
[[nodiscard]] std::uint16_t deadline_ms_for(std::uint16_t period_ms);

}  // namespace romano::experiments
