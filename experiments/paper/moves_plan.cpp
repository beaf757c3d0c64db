#include <algorithm>
#include <string>

#include "experiments/paper/moves.h"
#include "experiments/sweep/csv.h"
#include "overlay/sim/seed.h"

namespace romano::experiments {
namespace {

std::string name_of(Change change) {
    switch (change) {
        case Change::none:
            return "none";
        case Change::broker_dies:
            return "its broker dies";
        case Change::machine_dies:
            return "broker and router die";
        case Change::robots_leave:
            return "it drives into another cell";
    }
    return {};
}

std::string file_of(const MovesPlan& plan, Change change, std::size_t run) {
    return "moves_change" + std::to_string(static_cast<int>(change)) + "_seed" +
           std::to_string(plan.seed) + "_run" + std::to_string(run);
}

std::string to_csv(const MovesRun& run) {
    CsvRow silences;
    for (const double ms : run.silence_ms) silences.push_back(csv_number(ms));
    return csv_line({std::to_string(run.sent_qos0), std::to_string(run.lost_qos0),
                     std::to_string(run.sent_qos1), std::to_string(run.lost_qos1),
                     std::to_string(run.joins), std::to_string(run.reconnects)}) +
           csv_line(silences);
}

void add(MovesRun& sum, const std::string& csv) {
    const auto rows = parse_csv(csv);
    const auto count = [&](std::size_t column) { return std::stoul(rows.at(0).at(column)); };
    sum.sent_qos0 += count(0);
    sum.lost_qos0 += count(1);
    sum.sent_qos1 += count(2);
    sum.lost_qos1 += count(3);
    sum.joins += count(4);
    sum.reconnects += count(5);
    for (const std::string& ms : rows.at(1)) {
        sum.silence_ms.push_back(parse_csv_number(ms).value());
    }
}

constexpr const char* words =
    R"(Three brokers (profile wifi: beacons each 50 ms, given up after 500) with routers in a row, 30 m apart, on
channels of their own; five robots in the middle cell get 20 messages a second each, QoS 0 and 1 in turn.
"Silence": the longest time in which a robot got nothing, in 40 s. A robot looks at the routers' strengths
each 100 ms (mean with weight 0.3), joins one that is 6 dB stronger and then talks to that cell's broker;
scanning and associating take no time here. It drives at 1 m/s, and says where it is five times a second.)";

}  // namespace

std::vector<SeparateRun> runs_of(const MovesPlan& plan) {
    std::vector<SeparateRun> runs;
    for (const Change change : all_changes) {
        for (std::size_t i = 0; i < plan.runs; ++i) {
            runs.push_back(
                {file_of(plan, change, i), [change, seed = sim::seed_of(plan.seed, "moves", i)] {
                     return to_csv(moves_run(change, seed));
                 }});
        }
    }
    return runs;
}

Section moves_section(const MovesPlan& plan, const std::filesystem::path& folder) {
    SummaryTable table{.head = {"what happens to a robot", "robots", "silence: median", "most",
                                "QoS 0 lost", "of", "QoS 1 lost", "of", "joins", "reconnects"},
                       .units = {"", "", "ms", "ms", "", "", "", "", "", ""},
                       .rows = {}};
    PlotPanel panel{.title = "Longest silence of each robot",
                    .x_label = "0: none, 1: broker dies, 2: with its router, 3: drives away",
                    .y_label = "ms",
                    .series = {},
                    .log_y = true};
    PlotSeries cloud{.label = "", .points = {}, .line = true};
    for (const Change change : all_changes) {
        MovesRun sum;
        for (std::size_t i = 0; i < plan.runs; ++i) {
            add(sum, outcome_of(file_of(plan, change, i), folder));
        }
        std::ranges::sort(sum.silence_ms);
        table.rows.push_back({name_of(change), std::to_string(sum.silence_ms.size()),
                              number_text(sum.silence_ms.at(sum.silence_ms.size() / 2), 0),
                              number_text(sum.silence_ms.back(), 0), std::to_string(sum.lost_qos0),
                              std::to_string(sum.sent_qos0), std::to_string(sum.lost_qos1),
                              std::to_string(sum.sent_qos1), std::to_string(sum.joins),
                              std::to_string(sum.reconnects)});
        for (const double ms : sum.silence_ms) {
            cloud.points.push_back({.x = static_cast<double>(change), .y = ms});
        }
    }
    panel.series.push_back(std::move(cloud));
    return {.title = "Beyond the paper: failover and roaming",
            .words = words,
            .tables = {{"moves", std::move(table)}},
            .figure = {.name = "moves", .panels = {std::move(panel)}}};
}

}  // namespace romano::experiments
