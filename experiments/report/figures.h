// The figures of a report: what each asks of the runs, how it is drawn, and the words beside it.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "experiments/report/configuration.h"
#include "experiments/report/plot.h"

namespace romano::experiments {

struct Figure {
    std::string title;
    Plot plot;
    std::string shows;     // HTML: what to see
    std::string measured;  // HTML: how it was measured
};

/// Those that these runs have numbers for. `results` holds the raw samples.
[[nodiscard]] std::vector<Figure> figures_of(std::span<const Configuration> configurations,
                                             double fault_after_s,
                                             const std::filesystem::path& results);

}  // namespace romano::experiments
