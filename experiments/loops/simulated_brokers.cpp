#include "experiments/loops/simulated_brokers.h"

#include <chrono>
#include <stdexcept>
#include <utility>

#include "election/profile.h"
#include "overlay/sim/settlement.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr const election::Profile& lan = election::profiles[0];
constexpr sim::LinkQuality link{.delay_min = 1ms, .delay_max = 1250us};
constexpr sim::Node robots_node{5'000};

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

SimulatedBrokers::SimulatedBrokers(std::uint64_t seed, std::size_t brokers) {
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
    robots_ = std::make_unique<SimulatedSurroundings>(*world_, robots_node);
}

}  // namespace romano::experiments
