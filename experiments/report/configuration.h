// Runs that differ in nothing but repetition and seed are runs of one configuration: the report
// speaks of configurations, and shows each run as a point.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "experiments/measure/percentile.h"
#include "experiments/sweep/run_row.h"

namespace romano::experiments {

struct Configuration {
    std::vector<RunRow> runs;  // that succeeded, in order; may be empty
    std::vector<RunRow> failed;

    [[nodiscard]] const Cell& cell() const { return (runs.empty() ? failed : runs).front().cell; }
    /// Of the runs that measured it, in order.
    [[nodiscard]] std::vector<double> values(Measured RunRow::*measured) const;
    [[nodiscard]] Percentiles of(Measured RunRow::*measured) const;
    [[nodiscard]] std::optional<double> median(Measured RunRow::*measured) const {
        return of(measured).at(0.5);
    }
    [[nodiscard]] std::optional<double> sum(Measured RunRow::*measured) const;
};

/// The cells differ in nothing but number, repetition and seed.
[[nodiscard]] bool is_same_point(const Cell& a, const Cell& b);
/// In the order of their first runs.
[[nodiscard]] std::vector<Configuration> configurations_of(std::span<const RunRow> rows);

/// What differs between the configurations of a sweep, for labels: "3 brokers, acks 2". Axes in
/// `given` are left out, as are those that have one value in all of `among`.
enum class Axis : std::uint8_t {
    brokers,
    robots,
    rate,
    payload,
    qos,
    elector,
    detector,
    acks,
    clients,
    fault
};
[[nodiscard]] std::string label_of(const Cell& cell, std::span<const Configuration> among,
                                   std::span<const Axis> given);

}  // namespace romano::experiments
