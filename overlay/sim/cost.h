// What one broker of a cluster costs, against how many there are: what it says to its peers and
// hears from them, and the time its core takes. No faults, good links, the same robots at each
// broker. What a host of its own would show, without serialisation and without the network's own
// headers.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "overlay/cluster/messages.h"
#include "romano/base/time.h"

namespace romano::sim {

struct CostOptions {
    std::size_t brokers = 3;
    std::size_t robots_per_broker = 2;
    Duration publish_every{std::chrono::milliseconds{100}};  // each robot, QoS 1; one hears it
    std::uint32_t acks = 1;
    Duration beacon_every{std::chrono::milliseconds{10}};
    Duration detection_timeout{std::chrono::milliseconds{100}};
    Duration lasts{std::chrono::seconds{5}};
    std::function<std::size_t(const cluster::ClusterMessage&)> octets_of{};
    std::uint64_t seed = 1;
};

struct Rate {
    double messages_per_s = 0;
    double octets_per_s = 0;
};
/// By cluster::Delivery.
using Rates = std::array<Rate, 4>;

/// Means of one broker.
struct Cost {
    bool is_settled =
        false;  // all brokers agreed and all robots were connected: else it says little
    double publishes_per_s = 0;  // acknowledged, of the whole cluster
    Rates sent{};
    Rates received{};
    double core_share = 0;  // of one core of this machine
};

[[nodiscard]] Cost cost_of(const CostOptions& options);

}  // namespace romano::sim
