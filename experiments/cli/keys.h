// `romano keys`: keys for protected packets, made, looked at and withdrawn.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

void add_keys(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
