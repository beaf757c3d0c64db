// Confidence intervals from the runs themselves, by bootstrap (Efron 1979): the runs are drawn
// again and again, with replacement, and the interval is where the results of the draws lie.
// Nothing is assumed of how a figure is distributed.
//
// With few runs a plain bootstrap interval is too narrow, since drawn runs spread less than those
// they are drawn from. So deviations are stretched by sqrt(n / (n - 1)), and the ends are taken at
// Student's quantiles instead of the normal ones (Hesterberg 2015, "What Teachers Should Know About
// the Bootstrap", on narrowness bias).
//
// The draws come from a fixed seed: the same runs give the same interval.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace romano::experiments {

struct Interval {
    double low = 0;
    double high = 0;

    [[nodiscard]] bool contains(double value) const { return low <= value && value <= high; }
};

/// With fewer runs than this an interval covers the truth much less often than it says.
inline constexpr std::size_t runs_for_an_interval = 5;

[[nodiscard]] double mean_of(std::span<const double> values);

/// Of the mean. `confidence` in (0, 1), such as 0.95. Empty for fewer than two values.
[[nodiscard]] std::optional<Interval> interval_of_mean(std::span<const double> values,
                                                       double confidence);
/// Of mean(b) - mean(a). Empty when one has fewer than two values.
[[nodiscard]] std::optional<Interval> interval_of_difference(std::span<const double> a,
                                                             std::span<const double> b,
                                                             double confidence);
/// So many runs, spread as these are, give an interval of mean ± share * mean. Empty for fewer than
/// two values, or a mean of zero.
[[nodiscard]] std::optional<std::uint64_t> runs_needed(std::span<const double> values, double share,
                                                       double confidence);

}  // namespace romano::experiments
