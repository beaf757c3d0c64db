// `romano loops`: control loops at work, on the simulator.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

/// Adds the subcommand; the callback's exit code goes to `exit_code`.
void add_loops(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
