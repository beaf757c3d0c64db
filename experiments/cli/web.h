#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

/// `romano web`: the fleet as a page.
void add_web(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
