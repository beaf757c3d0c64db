// `romano brokers`: who is alive, who leads, sessions, addresses, view; as any broker tells it.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "experiments/cli/broker_options.h"
#include "experiments/watch/broker_watch.h"

namespace romano::experiments {

/// Asks a broker for what it knows of all, and shows it. Throws CommandError.
void see_brokers(const BrokerOptions& options, const std::function<void(const BrokerWatch&)>& show);

/// Adds the subcommand; the callback's exit code goes to `exit_code`. Throws CommandError.
void add_brokers(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
