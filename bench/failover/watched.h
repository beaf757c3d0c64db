// A watch: full load without a fault.
#pragma once

#include <cstdint>

namespace romano::bench {

/// What the brokers thought of each other while all of them lived.
struct Watched {
    double seconds = 0;
    std::uint64_t messages = 0;  // acknowledged, and arrived at another broker's client
    std::uint64_t lost = 0;
    std::uint64_t suspicions = 0;  // "lost b2", by each broker that thought so
    std::uint64_t take_overs = 0;  // of a living broker's address
};

}  // namespace romano::bench
