// `romano testbed`: machines of one's own for experiments, through ssh.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

void add_testbed(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
