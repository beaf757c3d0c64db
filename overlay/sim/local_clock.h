// The monotonic clock of one machine: it began somewhere else and runs fast or slow, by an
// eighth at most.
#pragma once

#include <chrono>
#include <cstdint>

#include "romano/base/time.h"

namespace romano::sim {

class LocalClock {
public:
    LocalClock() = default;
    LocalClock(Duration offset, std::int64_t drift_ppm) : offset_(offset), drift_ppm_(drift_ppm) {}

    /// What the machine's clock says at a virtual time.
    [[nodiscard]] Instant at(Instant virtual_time) const {
        const Duration t = virtual_time.time_since_epoch();
        return Instant{t + offset_ + t / 1'000'000 * drift_ppm_};
    }

    /// A virtual time at which the machine's clock says `local` or little more: a timer's.
    [[nodiscard]] Instant when(Instant local) const {
        if (local == never) return never;
        if (local <= at(Instant{})) return Instant{};
        const Duration wanted = local.time_since_epoch();
        Duration t = wanted - offset_;
        t -= t / 1'000'000 * drift_ppm_;
        // A clock that is fast by less than an eighth is not passed by seven eighths of what is
        // left.
        for (Duration left = local - at(Instant{t}); left > Duration{0};) {
            t += left > std::chrono::milliseconds{3} ? left * 7 / 8 : left;
            left = local - at(Instant{t});
        }
        return Instant{t};
    }

private:
    Duration offset_{0};
    std::int64_t drift_ppm_ = 0;
};

}  // namespace romano::sim
