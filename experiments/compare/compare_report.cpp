#include "experiments/compare/compare_report.h"

#include <algorithm>
#include <array>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "experiments/report/page.h"

namespace romano::experiments {
namespace {

// More would not be looked at.
constexpr std::size_t most_panels = 12;
constexpr std::size_t most_differences = 500;
constexpr std::size_t most_names = 10;

/// An axis of numbers, to draw against.
struct Across {
    Axis axis;
    const char* label;
    double (*value)(const Cell&);
};
constexpr std::array axes = {
    Across{Axis::brokers, "brokers", [](const Cell& cell) { return double{1} * cell.brokers; }},
    Across{Axis::robots, "robots", [](const Cell& cell) { return double{1} * cell.robots; }},
    Across{Axis::rate, "messages per second and publisher",
           [](const Cell& cell) { return cell.rate_per_s; }},
    Across{Axis::payload, "octets of payload",
           [](const Cell& cell) { return double{1} * cell.payload_octets; }}};

/// The axis with the most values among the compared configurations.
const Across& widest_axis(const Comparison& comparison) {
    const auto width = [&](const Across& across) {
        std::set<double> values;
        for (const Difference& each : comparison.differences) {
            values.insert(across.value(each.cell));
        }
        return values.size();
    };
    return *std::ranges::max_element(axes, {}, width);
}

PlotPoint point_at(double x, const std::vector<double>& values, double confidence) {
    PlotPoint point{.x = x, .y = mean_of(values)};
    if (const auto interval = interval_of_mean(values, confidence)) {
        point.low = interval->low;
        point.high = interval->high;
    }
    return point;
}

void add_point(PlotPanel& panel, std::size_t side, const std::string& label,
               const PlotPoint& point) {
    if (panel.series.size() <= side) panel.series.resize(side + 1);
    panel.series[side].label = label;
    panel.series[side].points.push_back(point);
}

/// B's marks stand beside A's, where they would cover them.
void set_aside(PlotPanel& panel) {
    const auto [least, most] = std::ranges::minmax(panel.series[0].points, {}, &PlotPoint::x);
    const double aside = std::max(most.x - least.x, 1.0) * 0.015;
    for (PlotPoint& point : panel.series[1].points) point.x += aside;
}

/// One panel for each combination of the other axes, with A and B in it.
Plot overlay(const Compared& compared, const Metric& metric, std::size_t number) {
    const Across& across = widest_axis(compared.comparison);
    const std::array given = {across.axis};
    const AxisLabels labels{compared.a};
    const ByPoint in_a = by_point(compared.a);
    const ByPoint in_b = by_point(compared.b);
    Plot plot{.name = "compare_" + std::to_string(number), .panels = {}};
    for (const Difference& each : compared.comparison.differences) {
        if (each.metric != &metric) continue;
        const std::string title = labels.of(each.cell, given);
        auto panel = std::ranges::find(plot.panels, title, &PlotPanel::title);
        if (panel == plot.panels.end()) {
            if (plot.panels.size() == most_panels) continue;
            panel = plot.panels.insert(
                panel, PlotPanel{.title = title,
                                 .x_label = across.label,
                                 .y_label = std::string{metric.name} + " (" + metric.unit + ")",
                                 .series = {}});
        }
        const double x = across.value(each.cell);
        const auto of_a = values_of(*in_a.at(point_of(each.cell)), metric);
        const auto of_b = values_of(*in_b.at(point_of(each.cell)), metric);
        add_point(*panel, 0, "A", point_at(x, of_a, compared.confidence));
        add_point(*panel, 1, "B", point_at(x, of_b, compared.confidence));
    }
    for (PlotPanel& panel : plot.panels) set_aside(panel);
    return plot;
}

std::size_t count(const Comparison& comparison, Verdict verdict) {
    return static_cast<std::size_t>(
        std::ranges::count(comparison.differences, verdict, &Difference::verdict));
}

std::string percent_text(const Difference& each) {
    if (each.mean_a == 0) return "–";
    const double percent = (each.mean_b - each.mean_a) / each.mean_a * 100;
    return (percent > 0 ? "+" : "") + number_text(Measured{percent}, 1);
}

std::string listed(const std::vector<std::string>& names) {
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), most_names); ++i) {
        text += (text.empty() ? "" : "; ") + names[i];
    }
    if (names.size() <= most_names) return text;
    return text + "; and " + std::to_string(names.size() - most_names) + " more";
}

}  // namespace

SummaryTable table_of(const Compared& compared, bool all) {
    SummaryTable table{
        .head = {"configuration", "figure", "unit", "runs", "A", "B", "B - A", "interval", "B is"},
        .units = {"", "", "", "A/B", "mean", "mean", "%", "of B - A", ""},
        .rows = {}};
    for (const Difference& each : compared.comparison.differences) {
        const bool is_seen = each.verdict == Verdict::better || each.verdict == Verdict::worse;
        if (!all && !is_seen) continue;
        const int decimals = each.metric->decimals;
        table.rows.push_back({each.configuration, each.metric->name, each.metric->unit,
                              std::to_string(each.runs_a) + "/" + std::to_string(each.runs_b),
                              number_text(each.mean_a, decimals),
                              number_text(each.mean_b, decimals), percent_text(each),
                              each.interval ? number_text(each.interval->low, decimals) + ".." +
                                                  number_text(each.interval->high, decimals)
                                            : "–",
                              std::string{name_of(each.verdict)}});
    }
    return table;
}

std::string verdict_of(const Compared& compared) {
    const Comparison& comparison = compared.comparison;
    const std::size_t few = count(comparison, Verdict::too_few_runs);
    const std::size_t judged = comparison.differences.size() - few;
    const auto chance = static_cast<double>(judged) * (1 - compared.confidence);
    std::string text =
        std::to_string(comparison.differences.size()) + " figures compared: B is better in " +
        std::to_string(count(comparison, Verdict::better)) + " and worse in " +
        std::to_string(count(comparison, Verdict::worse)) + "; no difference is seen in " +
        std::to_string(count(comparison, Verdict::none_seen)) + ".";
    if (judged > 0) {
        text += " Of " + std::to_string(judged) + " figures that were the same about " +
                number_text(chance, 1) + " would look different by chance.";
    }
    if (few > 0) {
        text += " " + std::to_string(few) +
                " have too few runs: " + std::to_string(runs_for_an_interval) +
                " on each side are needed (`repetitions` in the sweep file).";
    }
    if (!comparison.only_a.empty()) text += " Only A has: " + listed(comparison.only_a) + ".";
    if (!comparison.only_b.empty()) text += " Only B has: " + listed(comparison.only_b) + ".";
    return text;
}

std::string to_csv(const Compared& compared) {
    std::string text =
        csv_line({"configuration", "figure", "unit", "runs_a", "runs_b", "mean_a", "mean_b",
                  "difference", "interval_low", "interval_high", "verdict"});
    for (const Difference& each : compared.comparison.differences) {
        text += csv_line({each.configuration, each.metric->name, each.metric->unit,
                          std::to_string(each.runs_a), std::to_string(each.runs_b),
                          csv_number(each.mean_a), csv_number(each.mean_b),
                          csv_number(each.mean_b - each.mean_a),
                          each.interval ? csv_number(each.interval->low) : "",
                          each.interval ? csv_number(each.interval->high) : "",
                          std::string{name_of(each.verdict)}});
    }
    return text;
}

std::string to_json(const Compared& compared) {
    using nlohmann::ordered_json;
    ordered_json list = ordered_json::array();
    for (const Difference& each : compared.comparison.differences) {
        list.push_back({{"configuration", each.configuration},
                        {"figure", each.metric->name},
                        {"unit", each.metric->unit},
                        {"runs_a", each.runs_a},
                        {"runs_b", each.runs_b},
                        {"mean_a", each.mean_a},
                        {"mean_b", each.mean_b},
                        {"difference", each.mean_b - each.mean_a},
                        {"verdict", name_of(each.verdict)}});
        if (each.interval) {
            list.back()["interval"] = {each.interval->low, each.interval->high};
        }
    }
    const ordered_json json = {{"a", compared.name_a},
                               {"b", compared.name_b},
                               {"confidence", compared.confidence},
                               {"only_a", compared.comparison.only_a},
                               {"only_b", compared.comparison.only_b},
                               {"differences", list}};
    return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::string page_of(const Compared& compared, const std::filesystem::path& scripts) {
    std::string html = page_begin("A and B") + "<p class=\"sub\">A: <b>" +
                       html_text(compared.name_a) + "</b>. B: <b>" + html_text(compared.name_b) +
                       "</b>.</p>\n<p>" + html_text(verdict_of(compared)) + "</p>\n";
    std::size_t number = 0;
    for (const Metric& metric : compared_metrics()) {
        Figure figure{.title = metric.name,
                      .plot = overlay(compared, metric, ++number),
                      .shows = metric.is_better_higher ? "More is better." : "Less is better.",
                      .measured = "Marks are means over the runs, bars their intervals."};
        if (figure.plot.panels.empty()) continue;
        html += "<h2>" + html_text(figure.title) + "</h2>\n" + to_html(figure, scripts);
    }
    const SummaryTable table = table_of(compared, true);
    return html + "<h2>All differences</h2>\n<div class=\"wide\">\n" +
           to_html(first_rows(table, most_differences)) + "</div>\n<p class=\"how\">" +
           (table.rows.size() > most_differences
                ? "The first " + std::to_string(most_differences) + " of " +
                      std::to_string(table.rows.size()) + "; <code>differences.csv</code> has all. "
                : "") +
           "The interval is that of B - A at a confidence of " +
           number_text(Measured{compared.confidence * 100}, 1) +
           " %, by bootstrap over the runs. B is better or worse when it does not contain "
           "0.</p>\n" +
           std::string{page_end};
}

}  // namespace romano::experiments
