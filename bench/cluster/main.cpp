// romano_cluster_bench: what does it cost that brokers stand in for each other?

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/cluster/cost.h"
#include "romano/cli/loopback_network.h"
#include "romano/cli/real_number.h"

namespace {

using namespace romano;
using namespace romano::bench;

constexpr const char* examples = R"(Examples:
  romano_cluster_bench                                    (about three minutes)
  romano_cluster_bench --only qos1_acks_0 --only qos1_acks_1 --repetitions 7
  romano_cluster_bench --only peer_dies_many_sessions --repetitions 1 --seconds 15
  romano_cluster_bench --seconds 0.3 --repetitions 1      (does everything work?)
Three brokers and the load generator share this machine's cores. Writes runs.csv into --output.
Exit code: 0; 2 when something could not be run.)";

void check(const std::vector<std::string>& only) {
    const std::vector<CostScenario> scenarios = cost_scenarios(std::chrono::seconds{1});
    std::string names;
    for (const CostScenario& scenario : scenarios) names += ' ' + scenario.name;
    for (const std::string& name : only) {
        if (std::ranges::find(scenarios, name, &CostScenario::name) == scenarios.end()) {
            throw std::invalid_argument("--only `" + name + "` is no scenario; there are:" + names);
        }
    }
}

int run_all(const Options& options, double seconds, unsigned repetitions,
            const std::vector<std::string>& only) {
    const auto measured =
        std::chrono::duration_cast<Duration>(std::chrono::duration<double>{seconds});
    std::vector<CostRow> rows;
    std::filesystem::create_directories(options.output);
    for (unsigned repetition = 1; repetition <= repetitions; ++repetition) {
        for (const CostScenario& scenario : cost_scenarios(measured)) {
            const bool is_asked_for = std::ranges::count(only, scenario.name) > 0;
            if (only.empty() ? scenario.when_asked_for : !is_asked_for) continue;
            rows.push_back(run(scenario, repetition, options));
            const CostRow& row = rows.back();
            std::fprintf(stderr,
                         "%u/%u %-25s %8.0f deliveries/s  delay p50 %6.2f ms, most %6.1f  "
                         "answer p50 %6.2f ms, most %6.1f  brokers' CPU %4.0f %%  lost %.0f\n",
                         repetition, repetitions, scenario.name.c_str(), row.deliveries_per_s,
                         row.delivery_p50_ms, row.delivery_max_ms, row.acknowledgement_p50_ms,
                         row.acknowledgement_max_ms, row.broker_cpu_percent, row.lost);
            if (row.longest_turn_ms) {
                std::fprintf(stderr, "%s\n", text_of(row.machine_stalls).c_str());
            }
            std::ofstream(options.output / "runs.csv") << csv_of(rows);
        }
    }
    std::printf("%-74s %-14s %9s %9s %9s\n", "", "target", "median", "least", "most");
    for (const CostTarget& target : judge(rows)) {
        std::printf("%-74s %-14s %9.2f %9.2f %9.2f  %s\n", target.what.c_str(),
                    target.wanted.c_str(), target.measured, target.low, target.high,
                    target.holds ? "holds" : "MISSED");
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"What a cluster of three brokers costs its clients: throughput and delay.",
                 "romano_cluster_bench"};
    Options options;
    options.output = "results/cluster";
    options.network = "127.61.0";
    double seconds = 2;
    unsigned repetitions = 5;
    std::vector<std::string> only;
    app.add_option("--seconds", seconds, "Measured seconds of each run")
        ->check(real_number(0.1, 3600))
        ->capture_default_str();
    app.add_option("--repetitions", repetitions, "Of everything, in turn")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    app.add_option("--only", only, "Run this scenario (repeatable); see what it prints");
    app.add_option("--domain", options.domain, "DDS domain of the brokers")
        ->check(CLI::Range(0, 230))
        ->capture_default_str();
    app.add_option("--network", options.network, "Loopback network of the brokers")
        ->check(loopback_network())
        ->capture_default_str();
    app.add_option("--output", options.output, "Results folder")->capture_default_str();
    app.add_option("BROKER-OPTION", options.broker_arguments, "After --: options of the brokers");
    app.footer(examples);
    try {
        app.parse(argc, argv);
        check(only);
        options.broker_program =
            std::filesystem::read_symlink("/proc/self/exe").parent_path() / "romano-broker";
        return run_all(options, seconds, repetitions, only);
    } catch (const CLI::Success& asked) {
        return app.exit(asked);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "romano_cluster_bench: %s\n", error.what());
        return 2;
    }
}
