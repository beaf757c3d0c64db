// `romano status`: one broker's numbers on one screen, from its metrics page.
//
// Who is there, who leads and who serves what is told by `romano brokers`, from any broker; how
// much and how fast is counted by each broker for itself.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "experiments/watch/metrics_page.h"

namespace romano::experiments {

/// Adds the subcommand; the callback's exit code goes to `exit_code`. Throws CommandError.
void add_status(CLI::App& program, int& exit_code);

/// The screen: what `now` says, and the rates since `before`, which is `seconds` older.
[[nodiscard]] std::string status_screen(const MetricsPage& before, const MetricsPage& now,
                                        double seconds);

}  // namespace romano::experiments
