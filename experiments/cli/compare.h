// `romano compare A B`: two results beside each other.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

void add_compare(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
