#include "experiments/paper/cells_plan.h"

#include <algorithm>
#include <string>

#include "experiments/paper/many_cells.h"
#include "experiments/sweep/csv.h"
#include "overlay/sim/seed.h"

namespace romano::experiments {
namespace {

/// More than a cell carries.
constexpr double overload_of_a_cell = 300;
constexpr double overload_lasts_s = 3;
constexpr double hundred = 100;

double overload(std::size_t brokers) {
    return overload_of_a_cell * static_cast<double>(brokers);
}

std::string name_of(const CellsPlan& plan, std::size_t brokers, double rate) {
    return "cells_brokers" + std::to_string(brokers) + "_channels" + std::to_string(plan.channels) +
           "_rate" + csv_number(rate) + "_messages" + std::to_string(plan.messages) + "_seed" +
           std::to_string(plan.seed);
}

std::string capacity_name(const CellsPlan& plan, std::size_t brokers) {
    return "cells_full_brokers" + std::to_string(brokers) + "_channels" +
           std::to_string(plan.channels) + "_seed" + std::to_string(plan.seed);
}

std::string to_csv(const CellsRun& run) {
    return csv_line(
        {std::to_string(run.sent), std::to_string(run.delivered), csv_number(run.delivered_per_s)});
}

CellsRun run_from(const std::string& csv) {
    const CsvRow row = parse_csv(csv).at(0);
    return {.sent = std::stoul(row.at(0)),
            .delivered = std::stoul(row.at(1)),
            .delivered_per_s = parse_csv_number(row.at(2)).value()};
}

double percent(const CellsRun& run) {
    return hundred * static_cast<double>(run.delivered) / static_cast<double>(run.sent);
}

constexpr const char* words =
    R"(Each broker has a border router (230400 baud) and five robots of its own, 30 m from the next router; the
backbone is a wire, and an operator at each broker publishes to the robots of the next one. Cells take the
channels in turn: beyond so many brokers, cells share one and hear each other or not, as their distance has
it. "Carries": of 300/s for each cell.)";

}  // namespace

std::vector<SeparateRun> runs_of(const CellsPlan& plan) {
    std::vector<SeparateRun> runs;
    for (const std::size_t brokers : plan.brokers) {
        const ManyCells cells{.brokers = brokers,
                              .channels = plan.channels,
                              .seed = sim::seed_of(plan.seed, "cells", brokers)};
        const double full = overload(brokers);
        runs.push_back({capacity_name(plan, brokers), [cells, full] {
                            return to_csv(cells_run(
                                cells, full, static_cast<std::size_t>(full * overload_lasts_s)));
                        }});
        for (const double rate : plan.rates) {
            runs.push_back({name_of(plan, brokers, rate), [cells, rate, messages = plan.messages] {
                                return to_csv(cells_run(cells, rate, messages));
                            }});
        }
    }
    return runs;
}

Section cells_section(const CellsPlan& plan, const std::filesystem::path& folder) {
    SummaryTable table{.head = {"brokers", "cells on a channel", "carries", "of brokers x one"},
                       .units = {"", "", "1/s", ""},
                       .rows = {}};
    PlotPanel delivery{.title = "Delivery against rate",
                       .x_label = "messages/s",
                       .y_label = "delivered (%)",
                       .series = {},
                       .y_from = 0};
    PlotSeries capacities{.label = "", .points = {}};
    for (const double rate : plan.rates) {
        table.head.push_back(csv_number(rate) + "/s");
        table.units.emplace_back("%");
    }
    double of_one = 0;  // the carried of a cell in the smallest layout
    for (const std::size_t brokers : plan.brokers) {
        const auto count = static_cast<double>(brokers);
        const CellsRun full = run_from(outcome_of(capacity_name(plan, brokers), folder));
        if (of_one == 0) of_one = full.delivered_per_s / count;
        const std::size_t on_a_channel = (brokers + plan.channels - 1) / plan.channels;
        auto& row = table.rows.emplace_back();
        row = {std::to_string(brokers), std::to_string(on_a_channel),
               number_text(full.delivered_per_s, 0),
               number_text(full.delivered_per_s / (count * of_one), 2)};
        capacities.points.push_back({.x = count, .y = full.delivered_per_s});
        PlotSeries series{.label = std::to_string(brokers) + " brokers", .points = {}};
        for (const double rate : plan.rates) {
            const double share =
                percent(run_from(outcome_of(name_of(plan, brokers, rate), folder)));
            row.push_back(number_text(share, 1));
            series.points.push_back({.x = rate, .y = share});
        }
        delivery.series.push_back(std::move(series));
    }
    PlotPanel carried{.title = "What many cells carry",
                      .x_label = "brokers",
                      .y_label = "messages/s",
                      .series = {std::move(capacities)},
                      .y_from = 0};
    return {.title = "Beyond the paper: a cell for each broker",
            .words = words,
            .tables = {{"cells", std::move(table)}},
            .figure = {.name = "cells", .panels = {std::move(delivery), std::move(carried)}}};
}

}  // namespace romano::experiments
