// `romano cell`: modelled radio cells between real robots and real brokers.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

/// Adds the subcommand; the callback's exit code goes to `exit_code`.
void add_cell(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
