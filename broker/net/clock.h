// The machine's clocks as the cores want them: monotonic Instants, and what the wall clock said at
// the Instant with count 0.
#pragma once

#include <chrono>

#include "romano/base/time.h"

namespace romano::net {

inline Instant now() {
    return Instant{
        std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch())};
}

inline std::chrono::steady_clock::time_point to_steady_clock(Instant instant) {
    return std::chrono::steady_clock::time_point{
        std::chrono::duration_cast<std::chrono::steady_clock::duration>(
            instant.time_since_epoch())};
}

inline Duration unix_time() {
    return std::chrono::duration_cast<Duration>(
        std::chrono::system_clock::now().time_since_epoch());
}

inline Duration unix_time_at_zero() {
    return unix_time() - now().time_since_epoch();
}

}  // namespace romano::net
