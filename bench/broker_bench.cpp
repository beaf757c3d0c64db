// How near is the lone broker to what this machine can do, and what do keys cost? Reflector, broker
// at its three kinds of listeners, mosquitto and other brokers carry the same messages in turn, in
// one run; see README.md.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/contestant.h"
#include "bench/flood.h"
#include "bench/scenarios.h"
#include "bench/summary.h"
#include "broker/net/clock.h"
#include "broker/net/endpoint_text.h"
#include "experiments/load/load_run.h"
#include "experiments/load/mqttsn_clients.h"
#include "romano/cli/real_number.h"

namespace {

using namespace romano;
using namespace romano::bench;

constexpr const char* examples = R"(Examples:
  romano_broker_bench                                          (all, about five minutes)
  romano_broker_bench --only qos0_1_to_1 --only rate_10000_per_s --repetitions 7
  romano_broker_bench --csv runs.csv --json summary.json
  romano_broker_bench --only rate_1000_per_s --flood 50000     (each listener, also under forged datagrams)
  romano_broker_bench --only rate_10000_per_s --flood 50000 --contestant keys --contestant keys_flooded
  romano_broker_bench --other rsmb=127.0.0.1:1885 --other paho=127.0.0.1:10000   (run already)
  romano_broker_bench --small --seconds 0.05 --repetitions 1   (does everything work?)
It is worth something on a quiet machine only, with two cores or more.
Exit code: 0; 1 when messages were lost in a closed loop; 2 when something could not be run.
)";

struct Options {
    double seconds = 1;
    unsigned repetitions = 5;
    bool small = false;
    bool without_mosquitto = false;
    bool without_keys = false;
    double flood_per_s = 0;
    std::vector<std::string> others;  // NAME=ADDRESS:PORT
    std::vector<std::string> only;
    std::vector<std::string> contestants;
    std::string csv;
    std::string json;
};

Row run(const Scenario& scenario, const Entrant& entrant, unsigned repetition,
        double forged_per_s) {
    Contestant contestant{entrant, scenario.plan.clients()};
    Row row{.scenario = scenario.name, .contestant = entrant.name, .repetition = repetition};
    row.resident_start_kib = contestant.memory().resident_kib;
    row.sessions = scenario.plan.clients();
    double cpu_before = 0;
    double cpu_after = 0;
    Memory memory;
    const auto clients =
        contestant.clients(scenario.plan, scenario.is_for_cells ? experiments::SocketUse::one_each
                                                                : experiments::SocketUse::shared);
    std::optional<Flood> flood;
    if (entrant.forgery) {
        flood.emplace(dynamic_cast<experiments::MqttsnClients&>(*clients), scenario.plan.clients(),
                      *entrant.forgery, forged_per_s);
    }
    experiments::LoadRun load{
        scenario.plan,
        *clients,
        {.on_progress = [&](const std::string&, double) { contestant.check(); },
         .on_measuring = [&] { cpu_before = contestant.cpu_s(); },
         .on_measured =
             [&] {
                 cpu_after = contestant.cpu_s();
                 memory = contestant.memory();
             },
         .is_stopped = {},
         .on_turn =
             [&] {
                 if (flood) flood->go_on(net::now());
             },
         .never_sleeps = scenario.is_about_latency()}};
    const experiments::LoadFigures figures = load.run();
    row.resident_joined_kib = memory.resident_kib;
    row.proportional_joined_kib = memory.proportional_kib;
    row.anonymous_joined_kib = memory.anonymous_kib;
    row.deliveries_per_s = figures.delivered_per_s();
    row.p50_us = static_cast<double>(figures.latency.at(0.5).count()) * 1e-3;
    row.p99_us = static_cast<double>(figures.latency.at(0.99).count()) * 1e-3;
    row.cpu_us_a_message = (cpu_after - cpu_before) * 1e6 /
                           static_cast<double>(std::max<std::uint64_t>(figures.published, 1));
    row.generator_cpu_percent = figures.generator_cpu_percent;
    row.lost = static_cast<double>(figures.lost());
    row.duplicates = static_cast<double>(figures.duplicates);
    return row;
}

/// All, or those that were asked for.
std::vector<Scenario> chosen(const Options& options) {
    const auto measured =
        std::chrono::duration_cast<Duration>(std::chrono::duration<double>{options.seconds});
    std::vector<Scenario> all = scenarios(measured, options.small);
    std::string names;
    for (const Scenario& each : all) names += " " + each.name;
    for (const std::string& name : options.only) {
        if (std::ranges::find(all, name, &Scenario::name) == all.end()) {
            throw std::runtime_error("--only `" + name + "` is no scenario; there are:" + names);
        }
    }
    std::erase_if(all, [&](const Scenario& each) {
        return !options.only.empty() && std::ranges::count(options.only, each.name) == 0;
    });
    return all;
}

void add_flooded(std::vector<Entrant>& all, const Options& options) {
    using Packets = Endpoint::Packets;
    const auto add = [&](std::string name, Packets packets, bool has_keys,
                         std::optional<Forgery> forgery) {
        all.push_back({.kind = Kind::broker,
                       .name = std::move(name),
                       .packets = packets,
                       .has_keys = has_keys,
                       .forgery = forgery});
    };
    add("broker_flooded", Packets::plain, false, Forgery::publish);
    if (options.without_keys) return;
    add("keys", Packets::plain, true, std::nullopt);
    add("keys_flooded", Packets::plain, true, Forgery::connect);
    add("protected_flooded", Packets::sealed, true, Forgery::packet);
    add("dtls_flooded", Packets::dtls, true, Forgery::record);
    add("dtls_greeted", Packets::dtls, true, Forgery::hello);
}

std::vector<Entrant> entrants(const Options& options) {
    using Packets = Endpoint::Packets;
    std::vector<Entrant> all{{Kind::reflector, "reflector"}, {Kind::broker, "broker"}};
    if (!options.without_keys) {
        all.push_back({.kind = Kind::broker, .name = "protected", .packets = Packets::sealed});
        all.push_back({.kind = Kind::broker, .name = "dtls", .packets = Packets::dtls});
    }
    if (options.flood_per_s > 0) add_flooded(all, options);
    all.push_back({.kind = Kind::broker, .name = "cell", .has_cell = true});
    if (!options.without_mosquitto) all.push_back({Kind::mosquitto, "mosquitto"});
    for (const std::string& other : options.others) {
        const std::size_t equals = std::min(other.find('='), other.size());
        const std::string name = other.substr(0, equals);
        const auto address = net::parse_endpoint(other.substr(std::min(equals + 1, other.size())));
        if (!address || name.empty() || std::ranges::count(all, name, &Entrant::name) != 0) {
            throw std::runtime_error("--other `" + other +
                                     "` is not possible: a new name and where that broker serves, "
                                     "like rsmb=127.0.0.1:1885");
        }
        all.push_back({Kind::other, name, address});
    }
    for (const std::string& name : options.contestants) {
        if (std::ranges::count(all, name, &Entrant::name) != 0) continue;
        std::string names;
        for (const Entrant& each : all) names += " " + each.name;
        throw std::runtime_error("--contestant `" + name + "` takes no part; there are:" + names);
    }
    std::erase_if(all, [&](const Entrant& each) {
        return !options.contestants.empty() &&
               std::ranges::count(options.contestants, each.name) == 0;
    });
    return all;
}

/// Reflector and plain broker do everything; a flood is about the delay of others.
bool takes_part(const Entrant& entrant, const Scenario& scenario) {
    const bool is_plain = entrant.packets == Endpoint::Packets::plain;
    const bool is_for_floods = entrant.forgery || (entrant.has_keys && is_plain);
    if (is_for_floods) return scenario.is_about_latency() && scenario.with_others;
    const bool is_plain_broker = entrant.kind == Kind::broker && is_plain;
    if (entrant.has_cell || scenario.is_for_cells) return is_plain_broker && scenario.is_for_cells;
    if (entrant.kind == Kind::broker && scenario.with_keys) return true;
    return entrant.kind == Kind::reflector || is_plain_broker || scenario.with_others;
}

std::vector<Row> run_all(const Options& options) {
    const std::vector<Scenario> all = chosen(options);
    const std::vector<Entrant> contestants = entrants(options);
    std::vector<Row> rows;
    take_first_core();
    for (unsigned repetition = 1; repetition <= options.repetitions; ++repetition) {
        for (const Scenario& scenario : all) {
            for (const Entrant& entrant : contestants) {
                if (!takes_part(entrant, scenario)) continue;
                rows.push_back(run(scenario, entrant, repetition, options.flood_per_s));
                std::fprintf(stderr, "%u/%u %-18s %-17s %9.0f deliveries/s  p99 %8.1f us\n",
                             repetition, options.repetitions, scenario.name.c_str(),
                             entrant.name.c_str(), rows.back().deliveries_per_s,
                             rows.back().p99_us);
            }
        }
    }
    return rows;
}

int report(const Options& options, const std::vector<Row>& rows) {
    const std::vector<Target> targets = judge(rows);
    std::printf("%s\n%s", table_of(rows).c_str(), table_of(targets).c_str());
    if (!options.csv.empty()) std::ofstream(options.csv) << csv_of(rows);
    if (!options.json.empty()) std::ofstream(options.json) << json_of(rows, targets);
    for (const Row& row : rows) {
        const bool lossless = row.scenario.starts_with("rate_") || row.lost == 0;
        const bool is_ours = row.contestant == "broker" || row.contestant == "cell" ||
                             row.contestant == "protected" || row.contestant == "dtls";
        if (is_ours && !lossless) return 1;
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    Options options;
    CLI::App program{
        "How near the lone broker is to the machine's limit: reflector, broker, mosquitto "
        "and other brokers carry the same messages.",
        "romano_broker_bench"};
    program.add_option("--seconds", options.seconds, "Measured seconds of each run")
        ->check(real_number(0.02, 3600))
        ->capture_default_str();
    program.add_option("--repetitions", options.repetitions, "Of everything, in turn")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    program.add_option("--only", options.only, "Run this scenario (repeatable); see the table");
    program.add_option("--contestant", options.contestants,
                       "Run this one (repeatable); see the table");
    program.add_flag("--without-mosquitto", options.without_mosquitto, "It does not take part");
    program.add_flag("--without-keys", options.without_keys,
                     "The broker's protected:// and dtls:// addresses do not take part");
    program
        .add_option("--flood", options.flood_per_s,
                    "At fixed rates each listener once more, while so many forged datagrams a "
                    "second come, too")
        ->check(CLI::Range(1.0, 1e6));
    program
        .add_option("--other", options.others,
                    "Another MQTT-SN broker that runs already (repeatable); CPU and memory are "
                    "not seen, and it is not started afresh for each run")
        ->type_name("NAME=ADDR:PORT");
    program.add_flag("--small", options.small, "A hundred sessions instead of ten thousand");
    program.add_option("--csv", options.csv, "Write each run there, one row a run");
    program.add_option("--json", options.json, "Write medians and targets there");
    program.footer(examples);
    try {
        program.parse(argc, argv);
        return report(options, run_all(options));
    } catch (const CLI::Success& asked) {
        return program.exit(asked);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "romano_broker_bench: %s\n", error.what());
        return 2;
    }
}
