#include "experiments/paper/paper_report.h"

#include "experiments/sweep/csv.h"

namespace romano::experiments {
namespace {

constexpr const char* explanation =
    R"(One row a statement of the paper, a border router's UART and, where a queue overflowed, a reading of
what the router does then: it loses what it has no room for and goes on, or it takes nothing more (the
paper's system "fails after a while"). The paper does not state its baud: 115200 and 230400 are the two
usual ones that come nearest to its delays and to its table. Least and most are over the runs of a rate;
of the delays, over the messages or the steps from robot to robot.)";

SummaryTable delivery_table(const FiguresByBaud& all) {
    SummaryTable table{.head = {"baud", "rate", "least", "most", "stops: least", "most",
                                "runs overflowed", "after", "to", "then carries"},
                       .units = {"", "1/s", "%", "%", "%", "%", "", "messages", "messages", "1/s"},
                       .rows = {}};
    for (const auto& [baud, figures] : all) {
        for (const auto& [rate, row] : figures.delivery) {
            const auto [first, last] = row.overflow.value_or(Range{});
            table.rows.push_back({std::to_string(baud), csv_number(rate),
                                  number_text(row.goes_on.least, 1),
                                  number_text(row.goes_on.most, 1), number_text(row.stops.least, 1),
                                  number_text(row.stops.most, 1),
                                  std::to_string(row.overflowed) + '/' + std::to_string(row.runs),
                                  row.overflow ? number_text(first, 0) : "-",
                                  row.overflow ? number_text(last, 0) : "-",
                                  row.carried_per_s ? number_text(*row.carried_per_s, 1) : "-"});
        }
    }
    return table;
}

SummaryTable delay_table(const FiguresByBaud& all) {
    SummaryTable table{.head = {"baud", "robots", "robot", "least", "mean", "most"},
                       .units = {"", "", "", "ms", "ms", "ms"},
                       .rows = {}};
    for (const auto& [baud, figures] : all) {
        for (const auto& [robots, delays] : figures.delay) {
            for (std::size_t i = 0; i < delays.size(); ++i) {
                table.rows.push_back({std::to_string(baud), std::to_string(robots),
                                      std::to_string(i + 1), number_text(delays[i].least, 1),
                                      number_text(delays[i].mean, 1),
                                      number_text(delays[i].most, 1)});
            }
        }
    }
    return table;
}

SummaryTable statement_table(const FiguresByBaud& all) {
    SummaryTable table{.head = {"the paper states", "unit", "paper", "baud", "router", "least",
                                "most", "here", "difference", "verdict"},
                       .units = {},
                       .rows = {}};
    for (const Statement& statement : statements_of(all)) {
        for (const Finding& finding : statement.findings) {
            table.rows.push_back(
                {statement.what, statement.unit,
                 (statement.at_least ? ">= " : "") + csv_number(statement.papers),
                 std::to_string(finding.router_baud), finding.reading,
                 number_text(finding.ours.least, 1), number_text(finding.ours.most, 1),
                 number_text(finding.compared, 1),
                 number_text(difference_percent(statement, finding), 1) + " %", finding.verdict});
        }
    }
    return table;
}

Plot figure(const FiguresByBaud& all) {
    PlotPanel delivery{.title = "Delivery against rate",
                       .x_label = "messages/s",
                       .y_label = "least delivery, and to the most (%)",
                       .series = {},
                       .y_from = 0};
    PlotPanel delay{.title = "Delay of each robot, 20 messages/s to all",
                    .x_label = "robot",
                    .y_label = "mean delay (ms)",
                    .series = {},
                    .y_from = 0};
    for (const auto& [baud, figures] : all) {
        const std::string label = std::to_string(baud) + " baud";
        PlotSeries goes_on{.label = label, .points = {}};
        PlotSeries stops{.label = label + ", stops", .points = {}};
        for (const auto& [rate, row] : figures.delivery) {
            const auto point = [x = rate](const Range& range) {
                return PlotPoint{.x = x, .y = range.least, .low = range.least, .high = range.most};
            };
            goes_on.points.push_back(point(row.goes_on));
            stops.points.push_back(point(row.stops));
        }
        delivery.series.push_back(goes_on);
        delivery.series.push_back(stops);
        PlotSeries delays{.label = label, .points = {}};
        if (figures.delay.empty()) continue;
        const auto& most = figures.delay.rbegin()->second;
        for (std::size_t i = 0; i < most.size(); ++i) {
            delays.points.push_back({.x = static_cast<double>(i + 1), .y = most[i].mean});
        }
        delay.series.push_back(delays);
    }
    PlotSeries papers_delivery{.label = "the paper", .points = {}, .line = false};
    PlotSeries papers_delay{.label = "the paper", .points = {}};
    for (const auto& [rate, least, most] : papers_deliveries()) {
        papers_delivery.points.push_back({.x = rate, .y = least, .low = least, .high = most});
    }
    for (std::size_t i = 0; i < papers_robots; ++i) {
        papers_delay.points.push_back({.x = static_cast<double>(i + 1), .y = papers_delay_ms(i)});
    }
    delivery.series.push_back(papers_delivery);
    delay.series.push_back(papers_delay);
    return {.name = "paper", .panels = {std::move(delivery), std::move(delay)}};
}

}  // namespace

Section paper_section(const FiguresByBaud& figures) {
    return {.title = "The paper's table and figure again",
            .words = explanation,
            .tables = {{"statements", statement_table(figures)},
                       {"table", delivery_table(figures)},
                       {"delay", delay_table(figures)}},
            .figure = figure(figures)};
}

}  // namespace romano::experiments
