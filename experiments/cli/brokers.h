// `romano brokers`: who is alive, who leads, sessions, addresses, view; as any broker tells it.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

/// Adds the subcommand; the callback's exit code goes to `exit_code`. Throws CommandError.
void add_brokers(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
