#include "experiments/loops/faulty_brokers.h"

#include <chrono>
#include <stdexcept>
#include <utility>

#include "election/profile.h"
#include "overlay/sim/settlement.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr const election::Profile& lan = election::profiles[0];
constexpr std::uint16_t round_takes_ms = 5;
constexpr sim::LinkQuality link{.delay_min = 1ms, .delay_max = 1250us};

sim::ClusterWorldOptions cluster_options(std::uint64_t seed, std::size_t brokers) {
    sim::ClusterWorldOptions options;
    options.seed = seed;
    options.brokers = brokers;
    options.profile = lan.name;
    options.cluster.profile = lan.name;
    options.cluster.beacon_every = lan.beacon_every;
    options.cluster.detection_timeout = lan.detection_timeout;
    options.cluster.detector = "link";
    options.t_retry = lan.t_retry;
    options.are_invariants_judged = false;
    return options;
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

FaultyBrokers::FaultyBrokers(std::uint64_t seed, std::size_t brokers) {
    if (brokers == 1) {
        broker::BrokerOptions options = sim::LoneWorld::quick_broker();
        options.t_retry = lan.t_retry;
        lone_ = std::make_unique<sim::LoneWorld>(seed, std::move(options));
        world_ = lone_.get();
        struck_ = &lone_->broker();
    } else {
        cluster_ = std::make_unique<sim::ClusterWorld>(cluster_options(seed, brokers));
        world_ = cluster_.get();
        struck_ = &cluster_->broker(0);
        cluster_->start_brokers();
        if (!cluster_->run_until([&] { return !sim::disagreement(*cluster_); }, 20s)) {
            throw std::runtime_error("the brokers did not agree within 20 s");
        }
    }
    world_->clients().set_quality(link);
}

void FaultyBrokers::strike(BrokerFault fault) {
    switch (fault) {
        case BrokerFault::none:
        case BrokerFault::roaming:
            return;
        case BrokerFault::crash_for_good:
            return struck_->crash();
        case BrokerFault::crash:
            struck_->crash();
            return world_->events().after(back_after, [this] { struck_->start(); });
        case BrokerFault::silence:
            struck_->stop();
            return world_->events().after(back_after, [this] { struck_->go_on(); });
    }
}

std::uint16_t deadline_ms_for(std::uint16_t period_ms) {
    return static_cast<std::uint16_t>(lan.detection_timeout.count() + 2 * period_ms +
                                      round_takes_ms);
}

}  // namespace romano::experiments
