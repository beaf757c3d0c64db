// Two results side by side, such as a build before and after a change: for each configuration that
// both have, and each figure that both measured, how far the means of the runs are apart, and
// whether that is more than the runs' own spread would do by chance.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "experiments/measure/bootstrap.h"
#include "experiments/report/configuration.h"

namespace romano::experiments {

struct Metric {
    const char* name;
    const char* unit;
    Measured RunRow::*value;
    double scale;           // from the row's unit to `unit`
    bool is_better_higher;  // else lower
    int decimals;
};
[[nodiscard]] std::span<const Metric> compared_metrics();
/// In the metric's unit, of the runs that measured it.
[[nodiscard]] std::vector<double> values_of(const Configuration& configuration,
                                            const Metric& metric);

enum class Verdict : std::uint8_t {
    too_few_runs,  // fewer than runs_for_an_interval on a side
    none_seen,     // the interval contains 0
    better,        // of B
    worse,
};
[[nodiscard]] std::string_view name_of(Verdict verdict);

struct Difference {
    Cell cell;  // any of the configuration's
    std::string configuration;
    const Metric* metric;
    std::size_t runs_a, runs_b;
    double mean_a, mean_b;
    std::optional<Interval> interval;  // of mean_b - mean_a
    Verdict verdict;
};

struct Comparison {
    std::vector<Difference> differences;
    std::vector<std::string> only_a, only_b;  // configurations
};

/// `confidence` in (0, 1).
[[nodiscard]] Comparison compare(std::span<const Configuration> a, std::span<const Configuration> b,
                                 double confidence);

}  // namespace romano::experiments
