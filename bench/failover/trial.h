// One trial: a fault, and how long until the struck broker's client hears its new home.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "bench/failover/cluster.h"

namespace romano::bench {

/// The parts of a failover, one after the other, in milliseconds. Empty when a trace did not tell.
struct Parts {
    std::optional<double> detect = {};  // from the fault until the first survivor takes it for dead
    std::optional<double> agree = {};   // until the heir has a view without it
    std::optional<double> adopt = {};   // until the heir has adopted the sessions
    std::optional<double> address = {};  // until the heir is bound to the address
    std::optional<double> deliver = {};  // until the client has a message
};

struct Trial {
    std::uint32_t number = 0;
    std::string victim = {};
    bool led = false;
    std::string heir = {};
    std::optional<double> total_ms = {};  // empty: no message came in time
    Parts parts = {};
    std::optional<double> return_ms = {};  // from the revival until its client heard it again
    /// What the victim's client sent between the fault and the end of the trial: must be 0.
    std::uint64_t connects = 0;
    std::uint64_t registers = 0;
    std::uint64_t subscribes = 0;
    std::uint64_t handshakes = 0;  // of DTLS, begun
};

[[nodiscard]] double ms_between(Instant from, Instant to);

/// What the survivors' traces say about the time from `fault` to `arrival`.
void read_parts(const Cluster& cluster, std::size_t victim, Instant fault, Instant arrival,
                Trial& trial);

}  // namespace romano::bench
