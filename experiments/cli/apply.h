// `romano apply`: an application of the ROMANO paper on simulated robots, with its picture.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

/// Adds the subcommand; the callback's exit code goes to `exit_code`. Throws CommandError.
void add_apply(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
