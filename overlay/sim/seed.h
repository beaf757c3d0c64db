// One seed makes a whole run: every part draws from its own stream of random numbers, so that one
// more message here does not shift the dice there.
#pragma once

#include <cstdint>
#include <string_view>

namespace romano::sim {

/// The seed of one part's stream; SplitMix64 (Steele et al. 2014) over the run's seed, the part's
/// name and its number.
constexpr std::uint64_t seed_of(std::uint64_t run, std::string_view part,
                                std::uint64_t number = 0) {
    std::uint64_t state = run;
    const auto mix = [&state](std::uint64_t value) {
        state += value + 0x9E3779B97F4A7C15ULL;
        std::uint64_t z = state;
        z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
        z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
        state = z ^ (z >> 31U);
    };
    for (const char c : part) mix(static_cast<unsigned char>(c));
    mix(number);
    return state;
}

}  // namespace romano::sim
