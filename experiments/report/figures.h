// The figures of a report: what each asks of the runs, how it is drawn, and the words beside it.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "experiments/report/configuration.h"
#include "experiments/report/plot.h"
#include "experiments/sweep/sweep_file.h"

namespace romano::experiments {

struct Figure {
    std::string title;
    Plot plot;
    std::string shows;     // HTML: what to see
    std::string measured;  // HTML: how it was measured
};

/// How fine the times of a failover are, as a phrase: "10 ms", the time between two messages of a
/// publisher; "2 to 1000 ms" when the runs' rates differ.
[[nodiscard]] std::string publishing_interval_of(std::span<const RunRow> runs);

/// Those that these runs have numbers for. `results` holds the raw samples.
[[nodiscard]] std::vector<Figure> figures_of(std::span<const Configuration> configurations,
                                             const SweepSettings& settings,
                                             const std::filesystem::path& results);

}  // namespace romano::experiments
