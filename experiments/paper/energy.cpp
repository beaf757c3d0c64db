#include "experiments/paper/energy.h"

#include <string>
#include <utility>

#include "experiments/sweep/csv.h"

namespace romano::experiments {
namespace {

constexpr double milli = 1e3;

constexpr const char* words =
    R"(Means over the runs of the paper's table, of the radios alone: a CC2538 takes 20 mA to receive or listen and
24 mA to send at 0 dBm, at 3 V (Texas Instruments, SWRS096). "Awake": radios that always listen, as the
paper's do, so that what is idle is paid, too; all robots together for the robots. "Its frames": what would
be left of it if each radio were on for its own frames and acknowledgements alone.)";

struct Costs {
    double delivered = 0;
    double lasted_s = 0;
    double router_air_s = 0;
    double robots_air_s = 0;
};

Costs costs_of(const std::vector<DeliveryRun>& runs) {
    Costs costs;
    for (const DeliveryRun& run : runs) {
        costs.delivered += static_cast<double>(run.delivered);
        costs.lasted_s += run.lasted_s;
        costs.router_air_s += run.router_air_s;
        costs.robots_air_s += run.robots_air_s;
    }
    return costs;
}

}  // namespace

double energy_j(const Transceiver& radio, double lasted_s, double sending_s) {
    return radio.volts *
           (radio.receiving_a * (lasted_s - sending_s) + radio.transmitting_a * sending_s);
}

Section energy_section(const PaperPlan& plan, const std::filesystem::path& folder) {
    const Transceiver cc2538;
    SummaryTable table{.head = {"baud", "rate", "air: broker", "robot", "awake: broker", "robots",
                                "its frames: broker", "robot"},
                       .units = {"", "1/s", "ms", "ms", "mJ", "mJ", "mJ", "mJ"},
                       .rows = {}};
    PlotPanel panel{.title = "Energy of a delivered message, radios awake",
                    .x_label = "messages/s",
                    .y_label = "mJ",
                    .series = {},
                    .log_y = true};
    for (const std::uint32_t baud : plan.router_bauds) {
        PlotSeries broker{.label = "broker, " + std::to_string(baud) + " baud", .points = {}};
        PlotSeries robots{.label = "robots, " + std::to_string(baud) + " baud", .points = {}};
        for (const double rate : plan.rates) {
            const Costs costs = costs_of(delivery_runs(plan, baud, rate, folder));
            if (costs.delivered == 0) continue;
            const auto for_one = [&](double sum) {
                return number_text(milli * sum / costs.delivered, 2);
            };
            const double broker_j = energy_j(cc2538, costs.lasted_s, costs.router_air_s);
            const double robots_j =
                energy_j(cc2538, costs.lasted_s * papers_robots, costs.robots_air_s);
            const double air_s = costs.router_air_s + costs.robots_air_s;
            table.rows.push_back({std::to_string(baud), csv_number(rate),
                                  for_one(costs.router_air_s), for_one(costs.robots_air_s),
                                  for_one(broker_j), for_one(robots_j),
                                  for_one(energy_j(cc2538, air_s, costs.router_air_s)),
                                  for_one(energy_j(cc2538, air_s, costs.robots_air_s))});
            broker.points.push_back({.x = rate, .y = milli * broker_j / costs.delivered});
            robots.points.push_back({.x = rate, .y = milli * robots_j / costs.delivered});
        }
        panel.series.push_back(std::move(broker));
        panel.series.push_back(std::move(robots));
    }
    return {.title = "Beyond the paper: what a message costs",
            .words = words,
            .tables = {{"energy", std::move(table)}},
            .figure = {.name = "energy", .panels = {std::move(panel)}}};
}

}  // namespace romano::experiments
