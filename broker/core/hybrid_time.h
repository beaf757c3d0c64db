// Hybrid logical clock (Kulkarni et al. 2014): orders what happened on different brokers by their
// roughly synchronised wall clocks, and never against cause and effect.
#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>

#include "romano/base/time.h"

namespace romano::broker {

/// Upper 48 bits: milliseconds since the Unix epoch. Lower 16 bits: counter within one millisecond.
struct HybridTime {
    std::uint64_t value = 0;

    [[nodiscard]] constexpr std::uint64_t unix_ms() const { return value >> 16U; }

    friend bool operator==(HybridTime, HybridTime) = default;
    friend auto operator<=>(HybridTime, HybridTime) = default;
};

class HybridClock {
public:
    /// `unix_time_at_zero`: what the wall clock said at the Instant with count 0.
    explicit constexpr HybridClock(Duration unix_time_at_zero) : offset_(unix_time_at_zero) {}

    /// A time later than all that were returned or observed before.
    constexpr HybridTime stamp(Instant now) {
        last_.value = std::max(last_.value + 1, wall(now));
        return last_;
    }

    /// What the wall clock says: no stamp, and not later than one.
    [[nodiscard]] constexpr HybridTime reading(Instant now) const { return {wall(now)}; }

    /// How long ago that was by the wall clocks; nothing when they disagree.
    [[nodiscard]] constexpr Duration since(HybridTime then, Instant now) const {
        if (reading(now) <= then) return Duration{0};
        return std::chrono::milliseconds{reading(now).unix_ms() - then.unix_ms()};
    }

    /// Takes note of another broker's time.
    constexpr void observe(HybridTime other) { last_ = std::max(last_, other); }

private:
    [[nodiscard]] constexpr std::uint64_t wall(Instant now) const {
        const auto since_epoch =
            std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch() + offset_);
        return static_cast<std::uint64_t>(since_epoch.count()) << 16U;
    }

    Duration offset_;
    HybridTime last_;
};

}  // namespace romano::broker
