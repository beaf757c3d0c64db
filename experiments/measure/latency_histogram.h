// Latencies of a load of any length in fixed memory: buckets that are at most 1/64 as wide as the
// values in them. A percentile is its bucket's upper edge: never too good, and at most a 64th too
// bad. Where all samples fit into memory, percentile.h is exact.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "romano/base/time.h"

namespace romano::experiments {

class LatencyHistogram {
public:
    void add(Duration latency) {
        const auto ns = latency.count() > 0 ? static_cast<std::uint64_t>(latency.count()) : 0;
        ++buckets_[bucket_of(ns)];
        ++count_;
        sum_ns_ += static_cast<double>(ns);
        if (latency > max_) max_ = latency;
    }

    [[nodiscard]] std::uint64_t count() const { return count_; }
    [[nodiscard]] Duration max() const { return max_; }
    /// Of the samples themselves, not of their buckets; 0 without samples.
    [[nodiscard]] Duration mean() const {
        if (count_ == 0) return {};
        return Duration{static_cast<Duration::rep>(sum_ns_ / static_cast<double>(count_))};
    }

    /// The latency that `share` (0 to 1) of all samples do not exceed; 0 without samples.
    [[nodiscard]] Duration at(double share) const {
        const double rank = share * static_cast<double>(count_);
        std::uint64_t below = 0;
        for (std::size_t bucket = 0; bucket < buckets_.size(); ++bucket) {
            below += buckets_[bucket];
            if (below != 0 && static_cast<double>(below) >= rank) {
                const Duration edge{static_cast<Duration::rep>(upper_edge(bucket))};
                return edge < max_ ? edge : max_;
            }
        }
        return max_;
    }

private:
    static constexpr unsigned fine_bits = 6;  // 64 buckets from one power of two to the next
    static constexpr std::uint64_t fine = 1U << fine_bits;

    static std::size_t bucket_of(std::uint64_t ns) {
        if (ns < fine) return ns;
        const auto power = static_cast<unsigned>(std::bit_width(ns)) - 1 - fine_bits;
        return fine * power + (ns >> power);
    }
    static std::uint64_t upper_edge(std::size_t bucket) {
        if (bucket < 2 * fine) return bucket;
        const std::size_t power = bucket / fine - 1;
        return ((bucket % fine + fine + 1) << power) - 1;
    }

    std::array<std::uint64_t, fine * 59> buckets_{};
    std::uint64_t count_ = 0;
    double sum_ns_ = 0;
    Duration max_{};
};

}  // namespace romano::experiments
