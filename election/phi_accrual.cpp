#include "election/phi_accrual.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace romano::election {

namespace {

// Beacons leave by a timer: a smaller deviation than this is luck, not knowledge. In beacon
// intervals.
constexpr double least_deviation = 0.5;
// With fewer gaps than this the distribution is unknown, and the fixed time-out decides.
constexpr std::size_t least_gaps = 10;
// Silences that were just not long enough widen the distribution, so that longer ones are not long
// enough either: some late beacons in a row would put a detection off for seconds. No silence is
// borne longer than so many of the fixed time-outs.
constexpr int most_timeouts = 3;

/// -log10 of the upper tail of the normal distribution at `z` deviations.
double phi_at(double z) {
    constexpr double smallest = 1e-300;  // erfc underflows far out; any threshold is passed there
    return -std::log10(std::max(0.5 * std::erfc(z / std::sqrt(2.0)), smallest));
}

/// The z at which phi_at(z) reaches `threshold`, to a thousandth.
double deviations_for(double threshold) {
    double z = 0;
    while (phi_at(z) < threshold && z < 37) z += 0.001;
    return z;
}

}  // namespace

PhiAccrualDetector::PhiAccrualDetector(const DetectorOptions& options)
    : options_(options), deviations_at_threshold_(deviations_for(options.phi_threshold)) {}

double PhiAccrualDetector::Peer::mean() const {
    return sum / static_cast<double>(gaps.size());
}

double PhiAccrualDetector::Peer::deviation() const {
    const double variance = sum_of_squares / static_cast<double>(gaps.size()) - mean() * mean();
    return std::max(std::sqrt(std::max(variance, 0.0)), least_deviation);
}

void PhiAccrualDetector::on_beacon(Instant now, NodeId node) {
    const auto [found, is_new] = peers_.try_emplace(node);
    Peer& peer = found->second;
    if (!is_new && peer.alive) {
        const std::chrono::duration<double> gap = now - peer.last_beacon;
        const std::chrono::duration<double> interval = options_.beacon_every;
        // A gap in which we did not tick was our own stall: it says nothing about the peer.
        const double gaps = std::min(gap / interval, peer.silence + 1.5);
        peer.gaps.push_back(gaps);
        peer.sum += gaps;
        peer.sum_of_squares += gaps * gaps;
        if (peer.gaps.size() > window) {
            const double oldest = peer.gaps.front();
            peer.gaps.pop_front();
            peer.sum -= oldest;
            peer.sum_of_squares -= oldest * oldest;
        }
    }
    peer.last_beacon = now;
    peer.silence = 0;
    peer.alive = true;
}

void PhiAccrualDetector::on_gone(Instant, NodeId node) {
    const auto peer = peers_.find(node);
    if (peer == peers_.end() || !peer->second.alive) return;
    peer->second.alive = false;
    suspects_.push_back(node);
}

void PhiAccrualDetector::on_tick(Instant now) {
    if (now < next_tick_) return;
    next_tick_ = now + options_.beacon_every;  // late or not, one tick
    for (auto& [node, peer] : peers_) {
        if (!peer.alive) continue;
        peer.silence += 1;
        if (phi_of(peer, peer.silence) < options_.phi_threshold) continue;
        peer.alive = false;
        suspects_.push_back(node);
    }
}

bool PhiAccrualDetector::is_alive(NodeId node) const {
    const auto peer = peers_.find(node);
    return peer != peers_.end() && peer->second.alive;
}

std::vector<NodeId> PhiAccrualDetector::take_suspects() {
    return std::exchange(suspects_, {});
}

double PhiAccrualDetector::phi(NodeId node) const {
    const auto peer = peers_.find(node);
    return peer == peers_.end() ? 0.0 : phi_of(peer->second, peer->second.silence);
}

double PhiAccrualDetector::phi_of(const Peer& peer, double silence) const {
    const double limit = static_cast<double>(options_.timeout.count()) /
                         static_cast<double>(options_.beacon_every.count());
    if (peer.gaps.size() < least_gaps) return silence < limit ? 0.0 : options_.phi_threshold;
    const double phi = phi_at((silence - peer.mean()) / peer.deviation());
    return silence < most_timeouts * limit ? phi : std::max(phi, options_.phi_threshold);
}

Duration PhiAccrualDetector::detection_time() const {
    double longest = 0;
    for (const auto& [node, peer] : peers_) {
        if (!peer.alive || peer.gaps.size() < least_gaps) continue;
        longest = std::max(longest, peer.mean() + deviations_at_threshold_ * peer.deviation());
    }
    if (longest == 0) return options_.timeout;
    const Duration told{
        static_cast<std::int64_t>(longest * static_cast<double>(options_.beacon_every.count()))};
    return std::min(told, most_timeouts * options_.timeout);
}

}  // namespace romano::election
