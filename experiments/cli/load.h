// `romano load`: publishers and subscribers by the thousand against any MQTT-SN broker or gateway.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

/// Adds the subcommand; the callback's exit code goes to `exit_code`. Throws CommandError.
void add_load(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
