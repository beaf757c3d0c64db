// `romano control`: opens a loop between two robots, keeps it and says how it goes; or ends one.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

/// Adds the subcommand; the callback's exit code goes to `exit_code`. Throws CommandError.
void add_control(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
