#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

/// `romano record`: what goes over the brokers, into an MCAP file.
void add_record(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
