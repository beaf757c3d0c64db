// Runs that differ in nothing but repetition and seed are runs of one configuration: the report
// speaks of configurations, and shows each run as a point.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
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

/// The cell without what tells runs of one configuration apart: number, repetition and seed.
[[nodiscard]] Cell point_of(Cell cell);
/// In the order of their first runs.
[[nodiscard]] std::vector<Configuration> configurations_of(std::span<const RunRow> rows);

/// The configurations by their points.
using ByPoint = std::map<Cell, const Configuration*>;
[[nodiscard]] ByPoint by_point(std::span<const Configuration> configurations);

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
    backbone,
    router_baud,
    robot_baud,
    fault
};
/// What differs between configurations, for labels: "3 brokers, acks 2". An axis that has one value
/// in all of `among` is left out.
class AxisLabels {
public:
    explicit AxisLabels(std::span<const Configuration> among);
    /// Without the axes in `given`.
    [[nodiscard]] std::string of(const Cell& cell, std::span<const Axis> given) const;

private:
    std::map<Axis, std::set<std::string>> texts_;  // without those that do not apply
};

}  // namespace romano::experiments
