#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

/// `romano replay`: what `romano record` wrote down, once more.
void add_replay(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
