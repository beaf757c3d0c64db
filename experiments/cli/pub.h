// `romano pub`: publishes messages and waits until the broker has them.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

/// Adds the subcommand; the callback's exit code goes to `exit_code`. Throws CommandError.
void add_pub(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
