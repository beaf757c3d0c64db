// What people get of a sweep's results: the page, and the table on the terminal.
#pragma once

#include <filesystem>
#include <span>

#include "experiments/sweep/manifest.h"
#include "experiments/sweep/run_row.h"
#include "experiments/sweep/sweep_file.h"

namespace romano::experiments {

/// Writes report.html into `results`, and prints the table. Returns 1 when a run failed or a broker
/// broke its promise, else 0.
int tell(const Sweep& sweep, const Manifest& manifest, std::span<const RunRow> rows,
         const std::filesystem::path& results);

}  // namespace romano::experiments
