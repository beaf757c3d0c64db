// Exact percentiles of raw samples, by nearest rank: the smallest sample that at least the given
// share of all samples does not exceed. No interpolation, no buckets: every answer is a sample.
#pragma once

#include <optional>
#include <vector>

namespace romano::experiments {

class Percentiles {
public:
    Percentiles() = default;
    explicit Percentiles(std::vector<double> samples);

    /// `share` in (0, 1]: 0.5 is the median, 1 the maximum. Empty without samples.
    [[nodiscard]] std::optional<double> at(double share) const;
    [[nodiscard]] std::optional<double> min() const;
    [[nodiscard]] std::optional<double> max() const;
    [[nodiscard]] std::size_t count() const { return sorted_.size(); }

private:
    std::vector<double> sorted_;
};

}  // namespace romano::experiments
