// A watch: full load, without a fault, or with one whose victim comes back.
#pragma once

#include <cstdint>
#include <optional>

#include "bench/machine_stalls.h"

namespace romano::bench {

/// What the brokers thought of each other.
struct Watched {
    double seconds = 0;
    std::uint64_t messages = 0;  // acknowledged, and arrived at another broker's client
    std::uint64_t lost = 0;
    std::uint64_t suspicions = 0;   // "lost b2", by each broker that thought so
    std::uint64_t leases_lost = 0;  // by brokers that nothing befell
    std::uint64_t take_overs = 0;   // of a living broker's address
    std::uint32_t away_s = 0;       // the victim
    std::optional<MachineStalls::Seen> machine_stalls = {};
};

}  // namespace romano::bench
