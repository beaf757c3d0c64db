// The machine's clocks as the cores want them: monotonic Instants, and what the wall clock said at
// the Instant with count 0.
//
// Instants count while the machine is suspended: to a core that is a standstill like any other, and
// its lease is over when it goes on.
#pragma once

#include <time.h>

#include <chrono>

#include "romano/base/time.h"

namespace romano::net {

inline Instant now() {
    timespec time{};
    clock_gettime(CLOCK_BOOTTIME, &time);
    return Instant{std::chrono::seconds{time.tv_sec} + std::chrono::nanoseconds{time.tv_nsec}};
}

/// When that is if the machine is not suspended meanwhile: steady_clock does not count that time.
/// It is never too early: steady_clock is read last.
inline std::chrono::steady_clock::time_point to_steady_clock(Instant instant) {
    if (instant == never) return std::chrono::steady_clock::time_point::max();
    const Instant current = now();
    const auto steady = std::chrono::steady_clock::now();
    return instant <= current ? steady : steady + (instant - current);
}

inline Duration unix_time() {
    return std::chrono::duration_cast<Duration>(
        std::chrono::system_clock::now().time_since_epoch());
}

inline Duration unix_time_at_zero() {
    return unix_time() - now().time_since_epoch();
}

}  // namespace romano::net
