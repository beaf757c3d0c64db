#include "experiments/paper/paper_plan.h"

#include "experiments/sweep/csv.h"
#include "overlay/radio/radio_network.h"
#include "overlay/sim/seed.h"

namespace romano::experiments {
namespace {

std::string delivery_name(const PaperPlan& plan, std::uint32_t baud, double rate, std::size_t run) {
    return "delivery_baud" + std::to_string(baud) + "_rate" + csv_number(rate) + "_messages" +
           std::to_string(plan.messages) + "_channel" + std::to_string(plan.channel) + "_seed" +
           std::to_string(plan.seed) + "_run" + std::to_string(run);
}

std::string delay_name(const PaperPlan& plan, std::uint32_t baud, std::size_t robots) {
    return "delay_baud" + std::to_string(baud) + "_robots" + std::to_string(robots) + "_messages" +
           std::to_string(plan.delay_messages) + "_channel" + std::to_string(plan.channel) +
           "_seed" + std::to_string(plan.seed);
}

std::string to_csv(const DeliveryRun& run) {
    return csv_line({std::to_string(run.sent), std::to_string(run.delivered),
                     std::to_string(run.delivered_if_it_stops), std::to_string(run.given_up_on_air),
                     csv_number(run.lasted_s), csv_number(run.router_air_s),
                     csv_number(run.robots_air_s),
                     run.overflow_after ? std::to_string(*run.overflow_after) : "",
                     run.carried_per_s ? csv_number(*run.carried_per_s) : ""});
}

DeliveryRun delivery_from(const std::string& csv) {
    const CsvRow row = parse_csv(csv).at(0);
    DeliveryRun run{.sent = std::stoul(row.at(0)),
                    .delivered = std::stoul(row.at(1)),
                    .delivered_if_it_stops = std::stoul(row.at(2)),
                    .given_up_on_air = std::stoul(row.at(3)),
                    .lasted_s = parse_csv_number(row.at(4)).value(),
                    .router_air_s = parse_csv_number(row.at(5)).value(),
                    .robots_air_s = parse_csv_number(row.at(6)).value(),
                    .carried_per_s = parse_csv_number(row.at(8))};
    if (!row.at(7).empty()) run.overflow_after = std::stoul(row.at(7));
    return run;
}

std::string to_csv(const std::vector<RobotDelay>& robots) {
    std::string csv;
    for (const auto& [least, mean, most] : robots) {
        csv += csv_line({csv_number(least), csv_number(mean), csv_number(most)});
    }
    return csv;
}

std::vector<RobotDelay> delays_from(const std::string& csv) {
    std::vector<RobotDelay> robots;
    for (const CsvRow& row : parse_csv(csv)) {
        robots.push_back({parse_csv_number(row.at(0)).value(), parse_csv_number(row.at(1)).value(),
                          parse_csv_number(row.at(2)).value()});
    }
    return robots;
}

}  // namespace

std::optional<std::string> problem_with(const PaperPlan& plan) {
    for (const std::uint32_t baud : plan.router_bauds) {
        radio::RadioOptions options;
        options.router_baud = baud;
        options.cells.resize(1);
        options.cells[0].channel = plan.channel;
        if (auto problem = radio::problem_with(options)) return problem;
    }
    return std::nullopt;
}

std::vector<SeparateRun> runs_of(const PaperPlan& plan) {
    std::vector<SeparateRun> runs;
    for (const std::uint32_t baud : plan.router_bauds) {
        for (const double rate : plan.rates) {
            for (std::size_t i = 0; i < plan.runs; ++i) {
                const PaperCell cell{.router_baud = baud,
                                     .channel = plan.channel,
                                     .seed = sim::seed_of(plan.seed, "delivery", i)};
                runs.push_back(
                    {delivery_name(plan, baud, rate, i), [cell, rate, messages = plan.messages] {
                         return to_csv(delivery_run(cell, rate, messages));
                     }});
            }
        }
        for (std::size_t robots = 1; robots <= papers_robots; ++robots) {
            const PaperCell cell{.router_baud = baud,
                                 .channel = plan.channel,
                                 .robots = robots,
                                 .seed = sim::seed_of(plan.seed, "delay", robots)};
            runs.push_back({delay_name(plan, baud, robots), [cell, messages = plan.delay_messages] {
                                return to_csv(delay_run(cell, messages));
                            }});
        }
    }
    return runs;
}

std::vector<DeliveryRun> delivery_runs(const PaperPlan& plan, std::uint32_t baud, double rate,
                                       const std::filesystem::path& folder) {
    std::vector<DeliveryRun> runs;
    for (std::size_t i = 0; i < plan.runs; ++i) {
        runs.push_back(delivery_from(outcome_of(delivery_name(plan, baud, rate, i), folder)));
    }
    return runs;
}

FiguresByBaud figures_of(const PaperPlan& plan, const std::filesystem::path& folder) {
    FiguresByBaud figures;
    for (const std::uint32_t baud : plan.router_bauds) {
        for (const double rate : plan.rates) {
            figures[baud].delivery.emplace(rate,
                                           figures_of(delivery_runs(plan, baud, rate, folder)));
        }
        for (std::size_t robots = 1; robots <= papers_robots; ++robots) {
            figures[baud].delay.emplace(
                robots, delays_from(outcome_of(delay_name(plan, baud, robots), folder)));
        }
    }
    return figures;
}

}  // namespace romano::experiments
