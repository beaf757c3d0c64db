#include "experiments/report/configuration.h"

#include <algorithm>
#include <array>
#include <utility>

namespace romano::experiments {
namespace {

std::string counted(std::uint32_t count, const char* noun) {
    return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string text_of(const Cell& cell, Axis axis) {
    switch (axis) {
        case Axis::brokers:
            return counted(cell.brokers, "broker");
        case Axis::robots:
            return counted(cell.robots, "robot");
        case Axis::rate:
            return csv_number(cell.rate_per_s) + "/s";
        case Axis::payload:
            return std::to_string(cell.payload_octets) + " octets";
        case Axis::qos:
            return "QoS " + cell.qos.text();
        case Axis::elector:
            return cell.elector;
        case Axis::detector:
            return cell.detector;
        case Axis::acks:
            return cell.acks.empty() ? "" : "acks " + cell.acks;
        case Axis::clients:
            return cell.clients;
        case Axis::fault:
            return cell.fault == Fault::none ? "no fault" : std::string{name_of(cell.fault)};
    }
    return "";
}

constexpr std::array all_axes = {Axis::brokers, Axis::robots,  Axis::rate,     Axis::payload,
                                 Axis::qos,     Axis::elector, Axis::detector, Axis::acks,
                                 Axis::clients, Axis::fault};

Cell without_repetition(Cell cell) {
    cell.number = 0;
    cell.repetition = 0;
    cell.seed = 0;
    return cell;
}

}  // namespace

bool is_same_point(const Cell& a, const Cell& b) {
    return without_repetition(a) == without_repetition(b);
}

std::vector<double> Configuration::values(Measured RunRow::*measured) const {
    std::vector<double> values;
    for (const RunRow& run : runs) {
        if (run.*measured) values.push_back(*(run.*measured));
    }
    return values;
}

Percentiles Configuration::of(Measured RunRow::*measured) const {
    return Percentiles{values(measured)};
}

std::optional<double> Configuration::sum(Measured RunRow::*measured) const {
    std::optional<double> sum;
    for (const RunRow& run : runs) {
        if (run.*measured) sum = sum.value_or(0) + *(run.*measured);
    }
    return sum;
}

std::vector<Configuration> configurations_of(std::span<const RunRow> rows) {
    std::vector<Configuration> configurations;
    std::vector<RunRow> ordered(rows.begin(), rows.end());
    std::ranges::stable_sort(ordered, {}, [](const RunRow& row) { return row.cell.number; });
    for (const RunRow& row : ordered) {
        auto found = std::ranges::find_if(configurations, [&](const Configuration& each) {
            return is_same_point(each.cell(), row.cell);
        });
        if (found == configurations.end()) {
            found = configurations.insert(found, Configuration{});
        }
        (row.ok() ? found->runs : found->failed).push_back(row);
    }
    return configurations;
}

std::string label_of(const Cell& cell, std::span<const Configuration> among,
                     std::span<const Axis> given) {
    std::string label;
    for (const Axis axis : all_axes) {
        if (std::ranges::find(given, axis) != given.end()) continue;
        const std::string text = text_of(cell, axis);
        const bool varies = std::ranges::any_of(among, [&](const Configuration& other) {
            const std::string others = text_of(other.cell(), axis);
            return !others.empty() && others != text;
        });
        if (!varies || text.empty()) continue;
        if (!label.empty()) label += ", ";
        label += text;
    }
    return label;
}

}  // namespace romano::experiments
