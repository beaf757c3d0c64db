#include "overlay/dds/beacon_sender.h"

#include <chrono>

namespace romano::dds {
namespace {

using SteadyClock = std::chrono::steady_clock;

Instant now() {
    return Instant{SteadyClock::now().time_since_epoch()};
}

}  // namespace

BeaconSender::BeaconSender(const Entity& participant, const std::string& topic, const Qos& qos,
                           const broker::LogId& sender, const overlay::Pulses& pulses)
    : writer_(participant, topic, qos, sender),
      pulses_(pulses),
      thread_([this](const std::stop_token& stop) { go_on_for_the_core(stop); }) {}

bool BeaconSender::send(Bytes body, Bytes pulse) {
    const std::scoped_lock lock(mutex_);
    const bool is_idle = pulses_.next() == never;
    pulse_.assign(pulse.begin(), pulse.end());
    if (pulse.empty()) {
        pulses_.end();
    } else {
        pulses_.on_beacon(now());
        if (is_idle) beacon_sent_.notify_one();
    }
    return writer_.write(body);
}

void BeaconSender::go_on_for_the_core(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
        const Instant next = pulses_.next();
        if (next == never) {
            beacon_sent_.wait(lock, stop, [this] { return pulses_.next() != never; });
            continue;
        }
        // Beacons that come meanwhile move it; they wake nobody.
        beacon_sent_.wait_until(lock, stop, SteadyClock::time_point{next.time_since_epoch()},
                                [] { return false; });
        if (pulses_.take_due(now()) && writer_.write(pulse_)) ++pulses_sent_;
    }
}

}  // namespace romano::dds
