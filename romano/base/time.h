// Time as the cores see it: points of a clock that nobody can read.
//
// A core is told the time with every input; it never asks. `CoreClock` therefore has no now():
// asking does not compile. A shell maps its own monotonic clock to Instants, the simulator
// counts them up.
#pragma once

#include <chrono>
#include <cstdint>

namespace romano {

#ifndef ROMANO_SHORT_TIME
using Duration = std::chrono::duration<std::int64_t, std::nano>;
#else  // for small chips, in all files alike: steps of 8 ms, which end after 198 days
using Duration = std::chrono::duration<std::int32_t, std::ratio<1, 125> >;
#endif

/// Rounded to the clock's steps where these are longer.
constexpr Duration to_duration(std::chrono::milliseconds time) {
    return std::chrono::duration_cast<Duration>(time);
}

struct CoreClock {
    using rep = Duration::rep;
    using period = Duration::period;
    using duration = Duration;
    using time_point = std::chrono::time_point<CoreClock, Duration>;
    static constexpr bool is_steady = true;
};

using Instant = CoreClock::time_point;

/// "Nothing is due": what next_wakeup() answers when a core waits for no time.
inline constexpr Instant never = Instant::max();

}  // namespace romano
