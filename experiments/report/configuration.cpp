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
        case Axis::backbone:
            return backbone_text(cell);
        case Axis::router_baud:
            return router_baud_text(cell);
        case Axis::robot_baud:
            return robot_baud_text(cell);
        case Axis::fault:
            return cell.fault == Fault::none ? "no fault" : std::string{name_of(cell.fault)};
    }
    return "";
}

constexpr std::array all_axes = {Axis::brokers, Axis::robots,   Axis::rate,        Axis::payload,
                                 Axis::qos,     Axis::elector,  Axis::detector,    Axis::acks,
                                 Axis::clients, Axis::backbone, Axis::router_baud, Axis::robot_baud,
                                 Axis::fault};

}  // namespace

Cell point_of(Cell cell) {
    cell.number = 0;
    cell.repetition = 0;
    cell.seed = 0;
    return cell;
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
    std::map<Cell, std::size_t> places;
    for (const RunRow& row : ordered) {
        const auto [place, is_new] = places.try_emplace(point_of(row.cell), configurations.size());
        if (is_new) configurations.emplace_back();
        Configuration& found = configurations[place->second];
        (row.ok() ? found.runs : found.failed).push_back(row);
    }
    return configurations;
}

ByPoint by_point(std::span<const Configuration> configurations) {
    ByPoint found;
    for (const Configuration& each : configurations) found.emplace(point_of(each.cell()), &each);
    return found;
}

AxisLabels::AxisLabels(std::span<const Configuration> among) {
    for (const Configuration& each : among) {
        for (const Axis axis : all_axes) {
            std::string text = text_of(each.cell(), axis);
            if (!text.empty()) texts_[axis].insert(std::move(text));
        }
    }
}

std::string AxisLabels::of(const Cell& cell, std::span<const Axis> given) const {
    std::string label;
    for (const auto& [axis, texts] : texts_) {
        if (texts.size() < 2 || std::ranges::find(given, axis) != given.end()) continue;
        const std::string text = text_of(cell, axis);
        if (text.empty()) continue;
        if (!label.empty()) label += ", ";
        label += text;
    }
    return label;
}

}  // namespace romano::experiments
