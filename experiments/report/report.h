// report.html: what a sweep found, in one file that needs nothing else: verdict, figures, table,
// failed runs, how to run it again.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "experiments/sweep/manifest.h"
#include "experiments/sweep/run_row.h"
#include "experiments/sweep/sweep_file.h"

namespace romano::experiments {

/// Reads the samples in `results`, and leaves the plots' scripts there.
[[nodiscard]] std::string report_of(const Sweep& sweep, const Manifest& manifest,
                                    std::span<const RunRow> rows,
                                    const std::filesystem::path& results);

}  // namespace romano::experiments
