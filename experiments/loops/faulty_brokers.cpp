#include "experiments/loops/faulty_brokers.h"

#include <unistd.h>

#include <chrono>
#include <utility>

#include "election/profile.h"
#include "experiments/loops/radio_brokers.h"
#include "experiments/loops/real_brokers.h"
#include "experiments/loops/simulated_brokers.h"

namespace romano::experiments {
namespace {

constexpr const election::Profile& lan = election::profiles[0];

/// On the radio a round is four times the way between a robot and a broker.
constexpr std::uint16_t round_takes_ms(LoopWorld world) {
    return world == LoopWorld::radio ? 45 : 5;
}

}  // namespace

std::string_view name_of(BrokerFault fault) {
    switch (fault) {
        case BrokerFault::none:
            return "none";
        case BrokerFault::crash:
            return "crash, back after 1 s";
        case BrokerFault::crash_for_good:
            return "crash for good";
        case BrokerFault::silence:
            return "silent for 1 s";
        case BrokerFault::roaming:
            return "robots roam";
    }
    return {};
}

std::string_view name_of(LoopWorld world) {
    switch (world) {
        case LoopWorld::simulated:
            return "simulated";
        case LoopWorld::radio:
            return "radio";
        case LoopWorld::processes:
            return "processes";
    }
    return {};
}

std::string where_text(LoopWorld world) {
    switch (world) {
        case LoopWorld::simulated:
            return ", simulated";
        case LoopWorld::radio:
            return ", on modelled radio";
        case LoopWorld::processes:
            return ", on processes";
    }
    return {};
}

std::string how_it_is(LoopWorld world) {
    switch (world) {
        case LoopWorld::simulated:
            return "In virtual time; a datagram takes 1 to 1.25 ms.";
        case LoopWorld::radio:
            return "In virtual time; all robots are in one cell of IEEE 802.15.4 at the first "
                   "broker (ns-3, 6LoWPAN), whose border router has a UART of 230400 baud and "
                   "outlives the broker; who roams joins the cell at the second broker.";
        case LoopWorld::processes:
            return "In real time: romano-broker as processes, robots on sockets, on this "
                   "machine's loopback network.";
    }
    return {};
}

std::vector<Kind> kinds_with(const std::vector<std::size_t>& brokers) {
    std::vector<Kind> kinds;
    for (const std::size_t count : brokers) {
        kinds.push_back({count, BrokerFault::none});
        kinds.push_back({count, BrokerFault::crash_for_good});
        kinds.push_back({count, BrokerFault::crash});
        kinds.push_back({count, BrokerFault::silence});
        if (count > 1) kinds.push_back({count, BrokerFault::roaming});
    }
    return kinds;
}

std::string brokers_text(std::size_t brokers) {
    return std::to_string(brokers) + (brokers == 1 ? " broker" : " brokers");
}

void FaultyBrokers::strike(BrokerFault fault) {
    switch (fault) {
        case BrokerFault::none:
            return;
        case BrokerFault::roaming:
            return drive_on();
        case BrokerFault::crash_for_good:
            return crash();
        case BrokerFault::crash:
            crash();
            return after(back_after, [this] { start_again(); });
        case BrokerFault::silence:
            stop();
            return after(back_after, [this] { go_on(); });
    }
}

std::unique_ptr<FaultyBrokers> make_brokers(const LoopGround& ground, std::size_t brokers,
                                            std::uint64_t seed) {
    switch (ground.world) {
        case LoopWorld::simulated:
            return std::make_unique<SimulatedBrokers>(seed, brokers);
        case LoopWorld::radio:
            return make_radio_brokers(seed, brokers);
        case LoopWorld::processes:
            std::filesystem::create_directories(ground.traces);
            return std::make_unique<RealBrokers>(ground.broker_program, brokers, ground.traces);
    }
    return nullptr;
}

std::string problem_with(const LoopGround& ground) {
    if (ground.world == LoopWorld::radio && !has_radio) {
        return "--worlds radio: this build has no radio channel; install ns-3 (Debian: "
               "libns3-dev) and build again, or leave it out";
    }
    if (ground.world == LoopWorld::processes &&
        ::access(ground.broker_program.c_str(), X_OK) != 0) {
        return "--worlds processes: no broker to run: `" + ground.broker_program.string() +
               "` is no program; build romano-broker, or name it with --broker";
    }
    return {};
}

std::uint16_t deadline_ms_for(LoopWorld world, std::uint16_t period_ms) {
    return static_cast<std::uint16_t>(lan.detection_timeout.count() + 2 * period_ms +
                                      round_takes_ms(world));
}

}  // namespace romano::experiments
