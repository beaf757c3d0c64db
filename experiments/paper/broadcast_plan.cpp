#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "experiments/paper/broadcast.h"
#include "experiments/sweep/csv.h"
#include "overlay/sim/seed.h"

namespace romano::experiments {
namespace {

using mqttsn::Qos;

constexpr double hundred = 100;
constexpr std::array ways{Way::unicast, Way::cell};
constexpr std::array levels{Qos::at_most_once, Qos::at_least_once};

std::string text_of(Qos qos) {
    return "QoS " + std::to_string(static_cast<int>(qos));
}

std::string file_of(const BroadcastPlan& plan, std::size_t robots, Qos qos, Way way) {
    return "broadcast_robots" + std::to_string(robots) + "_qos" +
           std::to_string(static_cast<int>(qos)) + "_" + std::string{name_of(way)} + "_messages" +
           std::to_string(plan.messages) + "_seed" + std::to_string(plan.seed);
}

std::string to_csv(const BroadcastRun& run) {
    return csv_line({csv_number(run.first_ms), csv_number(run.last_ms), csv_number(run.heard),
                     csv_number(run.air_ms)});
}

BroadcastRun run_from(const std::string& csv) {
    const CsvRow row = parse_csv(csv).at(0);
    const auto at = [&](std::size_t column) { return parse_csv_number(row.at(column)).value(); };
    return {.first_ms = at(0), .last_ms = at(1), .heard = at(2), .air_ms = at(3)};
}

constexpr const char* words =
    R"(A broker on a wire, a border router and its robots, 2 m around it; all UARTs have 115200 baud. One message
to all robots in five seconds. "Unicast" is the paper's way, and that of unmodified clients: one datagram
for each robot, one after the other. "Cell": the broker sends one datagram for all that listen to the cell;
at QoS 1 they answer spread over time, and who does not answer is sent its own. A broadcast frame is not
acknowledged on the air. "Air": of a message, all answers and repetitions with it.)";

}  // namespace

std::vector<SeparateRun> runs_of(const BroadcastPlan& plan) {
    std::vector<SeparateRun> runs;
    for (const Qos qos : levels) {
        for (const Way way : ways) {
            for (const std::size_t robots : plan.robots) {
                const std::uint64_t seed = sim::seed_of(plan.seed, "broadcast", robots);
                runs.push_back({file_of(plan, robots, qos, way),
                                [robots, qos, way, messages = plan.messages, seed] {
                                    return to_csv(broadcast_run(robots, qos, way, messages, seed));
                                }});
            }
        }
    }
    return runs;
}

Section broadcast_section(const BroadcastPlan& plan, const std::filesystem::path& folder) {
    SummaryTable table{
        .head = {"QoS", "way", "robots", "first robot", "last robot", "heard", "air"},
        .units = {"", "", "", "ms", "ms", "% of robots", "ms/message"},
        .rows = {}};
    std::vector<PlotPanel> panels;
    for (const Qos qos : levels) {
        PlotPanel& panel = panels.emplace_back(
            PlotPanel{.title = "Until the last robot has a message, " + text_of(qos),
                      .x_label = "robots in the cell",
                      .y_label = "delay (ms)",
                      .series = {},
                      .y_from = 0});
        for (const Way way : ways) {
            PlotSeries series{.label = std::string{name_of(way)}, .points = {}};
            for (const std::size_t robots : plan.robots) {
                const BroadcastRun run =
                    run_from(outcome_of(file_of(plan, robots, qos, way), folder));
                table.rows.push_back({std::to_string(static_cast<int>(qos)),
                                      std::string{name_of(way)}, std::to_string(robots),
                                      number_text(run.first_ms, 1), number_text(run.last_ms, 1),
                                      number_text(hundred * run.heard, 1),
                                      number_text(run.air_ms, 1)});
                series.points.push_back({.x = static_cast<double>(robots), .y = run.last_ms});
            }
            panel.series.push_back(std::move(series));
        }
    }
    return {.title = "Beyond the paper: one datagram for a whole cell",
            .words = words,
            .tables = {{"broadcast", std::move(table)}},
            .figure = {.name = "broadcast", .panels = std::move(panels)}};
}

}  // namespace romano::experiments
