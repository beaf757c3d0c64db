// `romano report` and `romano merge`: results that are there already.
#pragma once

#include <CLI/CLI.hpp>

namespace romano::experiments {

void add_report(CLI::App& program, int& exit_code);
void add_merge(CLI::App& program, int& exit_code);

}  // namespace romano::experiments
