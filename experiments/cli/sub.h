// `romano sub`: subscribes and prints what arrives.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

/// Adds the subcommand; the callback's exit code goes to `exit_code`. Throws CommandError.
void add_sub(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
