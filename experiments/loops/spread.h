// Many numbers in one field of a table.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "experiments/measure/percentile.h"
#include "experiments/report/summary_table.h"

namespace romano::experiments {

/// "1.2, 2.4, 3.6": least, median, greatest.
inline std::string spread(std::vector<double> numbers, int decimals) {
    const Percentiles of{std::move(numbers)};
    if (of.count() == 0) return number_text(std::nullopt, decimals);
    return number_text(of.min(), decimals) + ", " + number_text(of.at(0.5), decimals) + ", " +
           number_text(of.max(), decimals);
}

}  // namespace romano::experiments
