// Sends the core's beacons, and pulses from a thread of its own while the next one is late
// (overlay/pulses.h).
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "overlay/dds/sample_writer.h"
#include "overlay/pulses.h"
#include "romano/base/bytes.h"

namespace romano::dds {

class BeaconSender {
public:
    /// Throws DdsError.
    BeaconSender(const Entity& participant, const std::string& topic, const Qos& qos,
                 const broker::LogId& sender, const overlay::Pulses& pulses);

    /// A beacon, or a pulse of the core's own. `pulse` follows it as long as the core is late with
    /// the next one; empty: nothing does. False when DDS did not take it.
    bool send(Bytes body, Bytes pulse);
    [[nodiscard]] std::uint64_t pulses_sent() const { return pulses_sent_; }

private:
    void go_on_for_the_core(const std::stop_token& stop);

    std::mutex mutex_;  // of all but the count
    std::condition_variable_any beacon_sent_;
    SampleWriter writer_;
    overlay::Pulses pulses_;
    std::vector<std::uint8_t> pulse_;
    std::atomic<std::uint64_t> pulses_sent_{0};
    std::jthread thread_;  // ends before what it uses
};

}  // namespace romano::dds
