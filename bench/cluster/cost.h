// What a cluster costs its clients: one load, carried by brokers with one setting, then with
// another.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/failover/options.h"
#include "bench/machine_stalls.h"
#include "experiments/load/load_plan.h"

namespace romano::bench {

struct CostScenario {
    std::string name;
    experiments::LoadPlan plan;
    std::vector<std::size_t> homes;             // of the clients, in turn: brokers from 0
    std::vector<std::string> broker_arguments;  // besides name, addresses and domain
    std::optional<Fault> fault = {};            // of the last broker, for a third of the time
    bool brokers_prove_themselves = false;      // with --keys; the clients are plain nevertheless
    bool measures_turns = false;                // the last half minute, when all is measured
    bool when_asked_for = false;                // takes long: not without --only
    std::optional<std::size_t> publishers_at = {};  // publishers: at the first so many only
};

[[nodiscard]] std::vector<CostScenario> cost_scenarios(Duration measured);

/// One run of one scenario.
struct CostRow {
    std::string scenario;
    unsigned repetition = 0;
    double deliveries_per_s = 0;
    double delivery_p50_ms = 0;
    double delivery_max_ms = 0;
    double acknowledgement_p50_ms = 0;
    double acknowledgement_max_ms = 0;
    /// Of the messages for the clients of a broker that has just been killed.
    std::optional<double> orphans_delivery_p50_ms = {};
    std::optional<double> longest_turn_ms = {};              // of any broker
    std::optional<MachineStalls::Seen> machine_stalls = {};  // while turns were measured
    double broker_cpu_percent = 0;  // of all brokers together, in percent of one core
    double lost = 0;
};

/// Starts brokers, loads them, stops them. Throws std::runtime_error.
[[nodiscard]] CostRow run(const CostScenario& scenario, unsigned repetition,
                          const Options& brokers);

struct CostTarget {
    std::string what;
    std::string wanted;
    double measured;  // median over the repetitions
    double low;
    double high;
    bool holds;
};
[[nodiscard]] std::vector<CostTarget> judge(const std::vector<CostRow>& rows);

[[nodiscard]] std::string csv_of(const std::vector<CostRow>& rows);

}  // namespace romano::bench
