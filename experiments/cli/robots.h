// `romano robots`: which ROMANO nodes there are, as any broker tells; and what can be asked of one:
// `romano move`, `romano subscribe-robot`, `romano unsubscribe-robot`, `romano request`.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

/// Adds the subcommands; a callback's exit code goes to `exit_code`. Throws CommandError.
void add_robots(CLI::App& program, int& exit_code);
void add_robot_commands(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
