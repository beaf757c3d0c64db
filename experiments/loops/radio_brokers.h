// Brokers of a loop as cores in virtual time, with their robots on IEEE 802.15.4 (overlay/radio): a
// cell at the first broker and one at the second, which the robots join when they roam. A broker
// that crashes leaves its border router on, which then talks to whoever took its address over.
#pragma once

#include <memory>

#include "experiments/loops/faulty_brokers.h"

namespace romano::experiments {

/// Whether this build has the radio channel (ns-3).
extern const bool has_radio;

/// Throws std::runtime_error where there is no radio. One at a time in a process.
[[nodiscard]] std::unique_ptr<FaultyBrokers> make_radio_brokers(std::uint64_t seed,
                                                                std::size_t brokers);

}  // namespace romano::experiments
