#include "experiments/measure/percentile.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace romano::experiments {

Percentiles::Percentiles(std::vector<double> samples) : sorted_(std::move(samples)) {
    std::sort(sorted_.begin(), sorted_.end());
}

std::optional<double> Percentiles::at(double share) const {
    assert(share > 0 && share <= 1);
    if (sorted_.empty()) return std::nullopt;
    // The small step down keeps 0.99 * 100 (98.99999...) and 0.07 * 100 (7.00000000001) on rank.
    const double rank = std::ceil(share * static_cast<double>(sorted_.size()) - 1e-9);
    const auto index = static_cast<std::size_t>(std::max(rank, 1.0)) - 1;
    return sorted_[std::min(index, sorted_.size() - 1)];
}

std::optional<double> Percentiles::min() const {
    if (sorted_.empty()) return std::nullopt;
    return sorted_.front();
}

std::optional<double> Percentiles::max() const {
    if (sorted_.empty()) return std::nullopt;
    return sorted_.back();
}

}  // namespace romano::experiments
