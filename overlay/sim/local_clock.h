// The monotonic clock of one machine: it began somewhere else and runs a little fast or slow.
#pragma once

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
        while (at(Instant{t}) < local) t += local - at(Instant{t});
        return Instant{t};
    }

private:
    Duration offset_{0};
    std::int64_t drift_ppm_ = 0;
};

}  // namespace romano::sim
