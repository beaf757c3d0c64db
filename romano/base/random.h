// Random numbers that are the same on every machine: our own generator (PCG32, O'Neill 2014) and
// our own distributions, because those of the standard library differ between implementations
// and a seed must replay a run byte for byte.
#pragma once

#include <cstdint>

#include "romano/base/time.h"

namespace romano {

class Random {
public:
    explicit constexpr Random(std::uint64_t seed) : state_(seed + increment) { (void)next(); }

    /// A uniformly distributed 32-bit number.
    constexpr std::uint32_t next() {
        const std::uint64_t old = state_;
        state_ = old * 6364136223846793005ULL + increment;
        const auto mixed = static_cast<std::uint32_t>(((old >> 18U) ^ old) >> 27U);
        const auto rotation = static_cast<std::uint32_t>(old >> 59U);
        return (mixed >> rotation) | (mixed << ((32U - rotation) & 31U));
    }

    /// Uniform in [0, bound); 0 when bound is 0. Lemire's multiplication, bias below 2^-32 * bound.
    constexpr std::uint32_t below(std::uint32_t bound) {
        return static_cast<std::uint32_t>((std::uint64_t{next()} * bound) >> 32U);
    }

    /// True with the given probability, in parts per million.
    constexpr bool happens(std::uint32_t parts_per_million) {
        return below(1'000'000) < parts_per_million;
    }

    /// Uniform in [low, high), on a grid of (high - low) / 2^32.
    constexpr Duration between(Duration low, Duration high) {
        const auto width = static_cast<std::uint64_t>((high - low).count());
        const std::uint64_t high_part = (width >> 32U) * next();
        const std::uint64_t low_part = ((width & 0xFFFFFFFFU) * next()) >> 32U;
        return low + Duration{static_cast<Duration::rep>(high_part + low_part)};
    }

private:
    static constexpr std::uint64_t increment = 1442695040888963407ULL;
    std::uint64_t state_;
};

}  // namespace romano
