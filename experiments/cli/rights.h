// `romano rights`: who may publish and read what: a file's faults, and what brokers use.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

void add_rights(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
