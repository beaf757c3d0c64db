// How long something took, counted by ranges: plain increments, no allocation. The bounds are
// upper ones, in the ratio 1 : 2.5 : 5 : 10; what is longer than the last has a place of its own.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "romano/base/time.h"

namespace romano::net {

class LatencyHistogram {
public:
    static constexpr std::array<Duration, 13> bounds = {
        std::chrono::microseconds{25},   std::chrono::microseconds{50},
        std::chrono::microseconds{100},  std::chrono::microseconds{250},
        std::chrono::microseconds{500},  std::chrono::milliseconds{1},
        std::chrono::microseconds{2500}, std::chrono::milliseconds{5},
        std::chrono::milliseconds{10},   std::chrono::milliseconds{25},
        std::chrono::milliseconds{50},   std::chrono::milliseconds{100},
        std::chrono::seconds{1}};

    /// `times` of them took that long.
    void add(Duration took, std::uint64_t times) {
        std::size_t at = 0;
        while (at < bounds.size() && took > bounds[at]) ++at;
        counts_[at] += times;
        sum_ += took * static_cast<Duration::rep>(times);
    }

    /// How many ended within bounds[at] and beyond bounds[at - 1]; at bounds.size(): beyond all.
    [[nodiscard]] std::uint64_t count(std::size_t at) const { return counts_[at]; }
    [[nodiscard]] Duration sum() const { return sum_; }

private:
    std::array<std::uint64_t, bounds.size() + 1> counts_{};
    Duration sum_{0};
};

}  // namespace romano::net
