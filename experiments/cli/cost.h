// `romano cost`: what one broker costs, against how many there are.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

/// Adds the subcommand; the callback's exit code goes to `exit_code`.
void add_cost(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
