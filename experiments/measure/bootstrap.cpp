#include "experiments/measure/bootstrap.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

namespace romano::experiments {
namespace {

constexpr std::uint64_t seed = 1979;

/// Of a thousand runs a draw takes long, and their mean is so nearly normal that fewer draws do.
std::size_t draws_of(std::size_t runs) {
    return std::clamp<std::size_t>(4'000'000 / runs, 4'000, 10'000);
}

/// The mean of a draw from `values`, its deviation stretched.
class Draw {
public:
    explicit Draw(std::span<const double> values)
        : values_(values),
          mean_(mean_of(values)),
          stretch_(std::sqrt(static_cast<double>(values.size()) /
                             static_cast<double>(values.size() - 1))) {}

    double operator()(std::mt19937_64& random) const {
        double sum = 0;
        for (std::size_t i = 0; i < values_.size(); ++i) {
            // Its upper half as a share of all: a division would be most of the time.
            sum += values_[(random() >> 32U) * values_.size() >> 32U];
        }
        const double drawn = sum / static_cast<double>(values_.size());
        return mean_ + (drawn - mean_) * stretch_;
    }

private:
    std::span<const double> values_;
    double mean_;
    double stretch_;
};

double student_quantile(double freedom, double confidence) {
    return boost::math::quantile(boost::math::students_t(freedom), (1 + confidence) / 2);
}

/// Where Student's quantile lies on the normal distribution's scale.
Interval ends_of(std::vector<double> means, double freedom, double confidence) {
    const double outside =
        boost::math::cdf(boost::math::normal(), -student_quantile(freedom, confidence));
    const auto last = static_cast<double>(means.size() - 1);
    const auto at = [&](double share) {
        const auto place = static_cast<std::ptrdiff_t>(std::lround(share * last));
        std::nth_element(means.begin(), means.begin() + place, means.end());
        return means[static_cast<std::size_t>(place)];
    };
    return {.low = at(outside), .high = at(1 - outside)};
}

double deviation_of(std::span<const double> values) {
    const double mean = mean_of(values);
    double squares = 0;
    for (const double value : values) squares += (value - mean) * (value - mean);
    return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

}  // namespace

double mean_of(std::span<const double> values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::optional<Interval> interval_of_mean(std::span<const double> values, double confidence) {
    if (values.size() < 2) return std::nullopt;
    std::mt19937_64 random(seed);
    const Draw draw(values);
    std::vector<double> means(draws_of(values.size()));
    for (double& mean : means) mean = draw(random);
    return ends_of(std::move(means), static_cast<double>(values.size() - 1), confidence);
}

std::optional<Interval> interval_of_difference(std::span<const double> a, std::span<const double> b,
                                               double confidence) {
    if (a.size() < 2 || b.size() < 2) return std::nullopt;
    std::mt19937_64 random(seed);
    const Draw draw_a(a);
    const Draw draw_b(b);
    std::vector<double> differences(draws_of(std::max(a.size(), b.size())));
    for (double& difference : differences) difference = draw_b(random) - draw_a(random);
    // The smaller group decides how far the quantiles can be trusted.
    const auto freedom = static_cast<double>(std::min(a.size(), b.size()) - 1);
    return ends_of(std::move(differences), freedom, confidence);
}

std::optional<std::uint64_t> runs_needed(std::span<const double> values, double share,
                                         double confidence) {
    constexpr std::uint64_t most = 1'000'000;
    if (values.size() < 2) return std::nullopt;
    const double half_width = std::abs(mean_of(values)) * share;
    if (half_width == 0) return std::nullopt;
    const double deviation = deviation_of(values);
    const auto are_enough = [&](std::uint64_t runs) {
        const double quantile = student_quantile(static_cast<double>(runs - 1), confidence);
        return quantile * deviation / std::sqrt(static_cast<double>(runs)) <= half_width;
    };
    // More runs never make the interval wider.
    std::uint64_t few = 1;
    std::uint64_t enough = most;
    while (enough - few > 1) {
        const std::uint64_t middle = few + (enough - few) / 2;
        (are_enough(middle) ? enough : few) = middle;
    }
    return enough;
}

}  // namespace romano::experiments
