// `romano paper`: the paper's table and figure again, on a modelled radio cell.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

/// Adds the subcommand; the callback's exit code goes to `exit_code`.
void add_paper(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
