#include "bench/ros/figures.h"

#include "experiments/sweep/csv.h"

namespace romano::bench::ros {

using experiments::csv_line;

std::string to_csv(const Figures& figures) {
    std::string text = csv_line({"figure", "value"});
    for (const auto& [name, value] : figures.all()) {
        text += csv_line({name, experiments::csv_number(value)});
    }
    return text;
}

Figures figures_in(std::string_view csv) {
    Figures figures;
    for (const auto& row : experiments::parse_csv(csv)) {
        if (row.size() == 2) figures.set(row[0], experiments::parse_csv_number(row[1]));
    }
    return figures;
}

}  // namespace romano::bench::ros
