#include "experiments/cli/cost.h"

#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "experiments/report/plot.h"
#include "experiments/report/summary_table.h"
#include "experiments/sweep/csv.h"
#include "experiments/sweep/progress_bar.h"
#include "overlay/dds/body_codec.h"
#include "overlay/sim/cost.h"
#include "romano/cli/real_number.h"

namespace romano::experiments {
namespace {

constexpr const char* cost_examples = R"(Examples:
  romano cost                                        (2 to 100 brokers, two robots at each)
  romano cost --brokers 2,10,50 --beacon-ms 50       (how much slower beacons save)
  romano cost --robots 0 --json | jq '.[].core_share'
  romano cost --output cost                          (cost/cost.svg, cost.csv; 100 brokers take minutes)
Brokers, robots and network are simulated in virtual time (overlay/sim): the shipped cores, without
faults. Octets are those of the bodies that brokers exchange over DDS, without the headers of RTPS,
UDP and IP; a message to all peers is sent once (multicast). core_share is the part of one core of
this machine that one broker's core took, without coding and sockets: run it on an idle machine.
Exit code: 0; 1 when some cluster did not settle.
)";

constexpr std::array<const char*, 4> deliveries{"beacon", "log", "direct", "best_effort"};

struct Options {
    std::vector<std::size_t> brokers{2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 80, 100};
    std::size_t robots = 2;
    double publishes_per_s = 10;
    std::uint32_t acks = 1;
    int beacon_ms = 10;
    double seconds = 5;
    bool as_json = false;
    std::filesystem::path output{};
};

struct Point {
    std::size_t brokers;
    sim::Cost cost;
};

double total(const sim::Rates& rates) {
    double sum = 0;
    for (const sim::Rate& rate : rates) sum += rate.octets_per_s;
    return sum;
}

nlohmann::ordered_json to_json(const sim::Rates& rates) {
    nlohmann::ordered_json all;
    for (std::size_t i = 0; i < rates.size(); ++i) {
        all[deliveries[i]] = {{"messages_per_s", rates[i].messages_per_s},
                              {"octets_per_s", rates[i].octets_per_s}};
    }
    return all;
}

nlohmann::ordered_json to_json(std::size_t brokers, const Options& options, const sim::Cost& cost) {
    return {{"brokers", brokers},
            {"robots", brokers * options.robots},
            {"publishes_per_s", cost.publishes_per_s},
            {"acks", options.acks},
            {"beacon_every_ms", options.beacon_ms},
            {"virtual_s", options.seconds},
            {"is_settled", cost.is_settled},
            {"sent", to_json(cost.sent)},
            {"received", to_json(cost.received)},
            {"core_share", cost.core_share}};
}

std::string rounded(double number) {
    char text[32];
    std::snprintf(text, sizeof text, "%.1f", number);
    return text;
}

constexpr double kilo = 1e3;
constexpr auto beacon = static_cast<std::size_t>(cluster::Delivery::beacon);

std::string to_csv(const std::vector<Point>& points) {
    std::string csv =
        csv_line({"brokers", "publishes_per_s", "sent_octets_per_s", "sent_beacon_octets_per_s",
                  "received_octets_per_s", "received_beacon_octets_per_s", "core_share"});
    for (const auto& [brokers, cost] : points) {
        csv +=
            csv_line({std::to_string(brokers), csv_number(cost.publishes_per_s),
                      csv_number(total(cost.sent)), csv_number(cost.sent[beacon].octets_per_s),
                      csv_number(total(cost.received)),
                      csv_number(cost.received[beacon].octets_per_s), csv_number(cost.core_share)});
    }
    return csv;
}

Plot figure(const std::vector<Point>& points) {
    PlotSeries sent{.label = "sent", .points = {}};
    PlotSeries received{.label = "received", .points = {}};
    PlotSeries beacons{.label = "beacons", .points = {}};
    PlotSeries core{.label = {}, .points = {}};
    for (const auto& [brokers, cost] : points) {
        const auto x = static_cast<double>(brokers);
        sent.points.push_back({.x = x, .y = total(cost.sent) / kilo});
        received.points.push_back({.x = x, .y = total(cost.received) / kilo});
        beacons.points.push_back({.x = x, .y = cost.received[beacon].octets_per_s / kilo});
        core.points.push_back({.x = x, .y = 100 * cost.core_share});
    }
    PlotPanel traffic{.title = "One broker's traffic with its peers",
                      .x_label = "brokers",
                      .y_label = "kB/s (beacons: those received)",
                      .series = {sent, received, beacons},
                      .log_y = true};
    PlotPanel work{.title = "One broker's core",
                   .x_label = "brokers",
                   .y_label = "time of one processor core (%)",
                   .series = {core},
                   .y_from = 0};
    return {.name = "cost", .panels = {std::move(traffic), std::move(work)}};
}

/// After each count, so that nothing is lost when somebody loses patience.
void write(const std::filesystem::path& folder, const std::vector<Point>& points) {
    std::error_code failed;
    std::filesystem::create_directories(folder, failed);
    std::ofstream csv(folder / "cost.csv");
    if (!(csv << to_csv(points)).flush()) {
        throw std::runtime_error("cannot write into --output `" + folder.string() + "`");
    }
    if (points.empty()) return;
    if (const auto svg = draw(figure(points), folder)) {
        std::ofstream(folder / "cost.svg") << *svg << '\n';
    }
}

std::vector<std::string> to_row(const Point& point) {
    const auto& [brokers, cost] = point;
    return {std::to_string(brokers),
            rounded(cost.publishes_per_s),
            rounded(total(cost.sent) / kilo),
            rounded(cost.sent[beacon].octets_per_s / kilo),
            rounded(total(cost.received) / kilo),
            rounded(cost.received[beacon].octets_per_s / kilo),
            rounded(100 * cost.core_share)};
}

int run(const Options& options) {
    using namespace std::chrono_literals;
    dds::BodyCodec codec;
    sim::CostOptions of;
    of.robots_per_broker = options.robots;
    of.acks = options.acks;
    of.publish_every = std::chrono::duration_cast<Duration>(
        std::chrono::duration<double>(1 / options.publishes_per_s));
    of.beacon_every = std::chrono::milliseconds{options.beacon_ms};
    of.detection_timeout = 10 * of.beacon_every;
    of.lasts = std::chrono::duration_cast<Duration>(std::chrono::duration<double>(options.seconds));
    of.octets_of = [&codec](const cluster::ClusterMessage& message) {
        return codec.encode(message).size();
    };

    bool all_settled = true;
    std::vector<Point> points;
    if (!options.output.empty()) write(options.output, points);
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    SummaryTable table{
        .head = {"brokers", "publishes", "sent", "beacons", "received", "beacons", "core"},
        .units = {"", "1/s", "kB/s", "kB/s", "kB/s", "kB/s", "%"},
        .rows = {}};
    ProgressBar bar{stderr, options.brokers.size(), 0};
    for (const std::size_t brokers : options.brokers) {
        bar.show(0, std::to_string(brokers) + " brokers");
        of.brokers = brokers;
        const Point& point = points.emplace_back(Point{brokers, sim::cost_of(of)});
        all_settled = all_settled && point.cost.is_settled;
        rows.push_back(to_json(brokers, options, point.cost));
        table.rows.push_back(to_row(point));
        if (!options.output.empty()) write(options.output, points);
        bar.finish_cell(std::to_string(brokers) + " brokers: " +
                        rounded(100 * point.cost.core_share) + " % of a core for each");
    }
    bar.erase();
    std::puts(options.as_json ? rows.dump(2).c_str() : to_text(table).c_str());
    return all_settled ? 0 : 1;
}

}  // namespace

void add_cost(CLI::App& program, int& exit_code) {
    auto options = std::make_shared<Options>();
    CLI::App& command = *program.add_subcommand(
        "cost", "What one broker sends, hears and computes, against how many brokers there are");
    command.set_help_flag("--help", "Show this and examples, and exit");
    command.add_option("--brokers", options->brokers, "Counts of brokers, such as 2,10,100")
        ->delimiter(',')
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    command.add_option("--robots", options->robots, "Robots at each broker")
        ->check(CLI::Range(0, 50))
        ->capture_default_str();
    command.add_option("--rate", options->publishes_per_s, "Publishes of each robot, in 1/s")
        ->check(real_number(0.1, 1000.0))
        ->capture_default_str();
    command.add_option("--acks", options->acks, "Peers that must hold a publish")
        ->check(CLI::Range(0, 99))
        ->capture_default_str();
    command
        .add_option("--beacon-ms", options->beacon_ms,
                    "From one beacon to the next, in ms; a broker is given up after ten")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    command.add_option("--seconds", options->seconds, "Of virtual time for each count")
        ->check(real_number(0.1, 600.0))
        ->capture_default_str();
    command.add_option("--output", options->output, "Leave cost.csv and cost.svg in this folder");
    command.add_flag("--json", options->as_json, "Print the result as JSON");
    command.footer(cost_examples);
    command.callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace romano::experiments
