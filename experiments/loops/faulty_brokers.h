// The brokers of a loop, and what befalls the one that its robots talk to: one broker alone, or a
// cluster with the times of profile `lan` and with links (overlay/link). They are cores in virtual
// time (simulated_brokers.h), the same with the robots on a modelled radio (radio_brokers.h), or
// processes (real_brokers.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/robots/surroundings.h"

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

    FaultyBrokers() = default;
    virtual ~FaultyBrokers() = default;
    FaultyBrokers(const FaultyBrokers&) = delete;
    FaultyBrokers& operator=(const FaultyBrokers&) = delete;

    /// Of the robots, which begin at the first broker.
    [[nodiscard]] virtual Surroundings& surroundings() = 0;
    [[nodiscard]] virtual BrokerAddress address_of(std::size_t broker) const = 0;
    [[nodiscard]] Instant now() { return surroundings().now(); }

    virtual void run_for(Duration duration) = 0;
    /// True as soon as `condition` holds.
    virtual bool run_until(const std::function<bool()>& condition, Duration limit) = 0;

    /// Befalls the first broker now, and ends by itself. Who roams must be told to talk to the
    /// second one.
    void strike(BrokerFault fault);

protected:
    // What is done to the first broker.
    virtual void crash() = 0;
    virtual void start_again() = 0;
    virtual void stop() = 0;
    virtual void go_on() = 0;
    /// All robots are where they hear the second broker alone.
    virtual void drive_on() {}
    virtual void after(Duration delay, std::function<void()> action) = 0;
};

/// Where a loop and its brokers are.
enum class LoopWorld : std::uint8_t { simulated, radio, processes };
[[nodiscard]] std::string_view name_of(LoopWorld world);
/// Behind a title: ", on radio".
[[nodiscard]] std::string where_text(LoopWorld world);
/// A sentence on what is between robots and brokers there.
[[nodiscard]] std::string how_it_is(LoopWorld world);

struct LoopGround {
    LoopWorld world = LoopWorld::simulated;
    std::filesystem::path broker_program{};  // of processes
    std::filesystem::path traces{};          // a folder for what they print
};

/// They serve when this returns; `seed` means little to processes. Throws std::runtime_error when
/// that does not come.
[[nodiscard]] std::unique_ptr<FaultyBrokers> make_brokers(const LoopGround& ground,
                                                          std::size_t brokers, std::uint64_t seed);

/// One sentence on why there cannot be loops there; empty when there can.
[[nodiscard]] std::string problem_with(const LoopGround& ground);

/// README.md of romano/control, "How old a command can get": going on when a broker dies or falls
/// silent takes a deadline of F + 2 P + D, with F the detection time, and D what a round takes in
/// that world.
[[nodiscard]] std::uint16_t deadline_ms_for(LoopWorld world, std::uint16_t period_ms);

}  // namespace romano::experiments
