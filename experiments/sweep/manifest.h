// manifest.json: what is needed to understand a sweep's numbers and to run any of its cells again.
#pragma once

#include <string>
#include <vector>

#include "experiments/sweep/build_info.h"
#include "experiments/sweep/machine.h"
#include "experiments/sweep/sweep_file.h"

namespace romano::experiments {

/// A machine on which brokers ran.
struct BrokerHost {
    std::string name;
    std::vector<std::string> addresses;  // of its brokers
    std::string architecture;
    std::string broker_version;
};

struct Manifest {
    BuildInfo build;
    Machine machine;
    std::string started_utc;  // when the sweep was begun, or gone on with
    std::string sweep_file;   // absolute, as it was called
    std::string broker_version;
    std::string hosts_file = {};  // absolute; empty: the brokers ran on `machine`, too
    std::vector<BrokerHost> hosts = {};
};

[[nodiscard]] std::string to_json(const Manifest& manifest, const Sweep& sweep);
/// What it does not say stays empty. Throws SweepError when the text is no manifest; `file` names
/// it.
[[nodiscard]] Manifest parse_manifest(const std::string& text, const std::string& file);

/// The command that runs all of it.
[[nodiscard]] std::string run_command(const Manifest& manifest);
/// The command that runs one cell again, exactly.
[[nodiscard]] std::string rerun_command(const Manifest& manifest, const Cell& cell);

}  // namespace romano::experiments
