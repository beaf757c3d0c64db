#include "experiments/compare/comparison.h"

#include <algorithm>
#include <array>

namespace romano::experiments {
namespace {

constexpr std::array metrics = {
    Metric{"delivered", "%", &RunRow::delivery_ratio, 100, true, 2},
    Metric{"delay, median", "ms", &RunRow::delay_p50_ms, 1, false, 2},
    Metric{"delay, 99 %", "ms", &RunRow::delay_p99_ms, 1, false, 1},
    Metric{"delay to the last of a group, 99 %", "ms", &RunRow::fan_out_p99_ms, 1, false, 1},
    Metric{"failover, by the probe", "ms", &RunRow::failover_probe_ms, 1, false, 0},
    Metric{"until the last robot hears again", "ms", &RunRow::failover_last_ms, 1, false, 0},
    Metric{"without a leader", "ms", &RunRow::without_leader_ms, 1, false, 0},
    Metric{"between brokers", "kB/s", &RunRow::interbroker_octets_per_s, 1e-3, false, 1},
    Metric{"CPU of a broker", "% of a core", &RunRow::broker_cpu_percent_mean, 1, false, 1},
    Metric{"memory of a broker", "MiB", &RunRow::broker_rss_peak_mib_mean, 1, false, 1},
};

Verdict verdict_on(const Difference& difference) {
    if (std::min(difference.runs_a, difference.runs_b) < runs_for_an_interval) {
        return Verdict::too_few_runs;
    }
    if (difference.interval->contains(0)) return Verdict::none_seen;
    const bool is_higher = difference.mean_b > difference.mean_a;
    return is_higher == difference.metric->is_better_higher ? Verdict::better : Verdict::worse;
}

std::string name_in(const Cell& cell, const AxisLabels& labels) {
    const std::string label = labels.of(cell, {});
    return label.empty() ? describe(cell) : label;
}

}  // namespace

std::span<const Metric> compared_metrics() {
    return metrics;
}

std::vector<double> values_of(const Configuration& configuration, const Metric& metric) {
    std::vector<double> values = configuration.values(metric.value);
    for (double& value : values) value *= metric.scale;
    return values;
}

std::string_view name_of(Verdict verdict) {
    switch (verdict) {
        case Verdict::too_few_runs:
            return "too few runs";
        case Verdict::none_seen:
            return "no difference seen";
        case Verdict::better:
            return "better";
        case Verdict::worse:
            return "worse";
    }
    return "";
}

Comparison compare(std::span<const Configuration> a, std::span<const Configuration> b,
                   double confidence) {
    Comparison comparison;
    const AxisLabels labels_a{a};
    const AxisLabels labels_b{b};
    const ByPoint in_a = by_point(a);
    const ByPoint in_b = by_point(b);
    for (const Configuration& one : a) {
        const auto other = in_b.find(point_of(one.cell()));
        if (other == in_b.end()) {
            comparison.only_a.push_back(name_in(one.cell(), labels_a));
            continue;
        }
        for (const Metric& metric : metrics) {
            const auto of_a = values_of(one, metric);
            const auto of_b = values_of(*other->second, metric);
            if (of_a.empty() || of_b.empty()) continue;
            Difference difference{.cell = one.cell(),
                                  .configuration = name_in(one.cell(), labels_a),
                                  .metric = &metric,
                                  .runs_a = of_a.size(),
                                  .runs_b = of_b.size(),
                                  .mean_a = mean_of(of_a),
                                  .mean_b = mean_of(of_b),
                                  .interval = interval_of_difference(of_a, of_b, confidence),
                                  .verdict = Verdict::too_few_runs};
            difference.verdict = verdict_on(difference);
            comparison.differences.push_back(std::move(difference));
        }
    }
    for (const Configuration& one : b) {
        if (in_a.contains(point_of(one.cell()))) continue;
        comparison.only_b.push_back(name_in(one.cell(), labels_b));
    }
    return comparison;
}

}  // namespace romano::experiments
