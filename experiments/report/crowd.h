// A plot of ten thousand runs has more marks than anybody looks at, and a page of all its plots
// would be too large to open. What is drawn instead, and the sentence that says so.
#pragma once

#include <string>

#include "experiments/report/plot.h"

namespace romano::experiments {

/// A panel with more marks than this has one for each series and x: the median, with a bar from the
/// least to the most.
inline constexpr std::size_t most_marks = 2'000;
/// Of a panel with more series than this the first are drawn.
inline constexpr std::size_t most_series = 24;

/// HTML; empty when everything is drawn. Clouds of points (PlotSeries::small) stay as they are.
[[nodiscard]] std::string thin_out(Plot& plot);

}  // namespace romano::experiments
