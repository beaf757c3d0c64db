// Time as the cores see it: points of a clock that nobody can read.
//
// A core is told the time with every input; it never asks. `CoreClock` therefore has no now():
// asking does not compile. A shell maps its own monotonic clock to Instants, the simulator
// counts them up.
#pragma once

#include <chrono>
#include <cstdint>

namespace romano {

using Duration = std::chrono::duration<std::int64_t, std::nano>;

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
