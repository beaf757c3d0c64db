// `romano simulate`: the shipped cores in virtual time, run by seed, judged by the promises.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

/// Adds the subcommand; the callback's exit code goes to `exit_code`.
void add_simulate(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
