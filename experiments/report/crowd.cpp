#include "experiments/report/crowd.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "experiments/measure/percentile.h"

namespace romano::experiments {
namespace {

std::size_t marks_in(const PlotPanel& panel) {
    std::size_t count = 0;
    for (const PlotSeries& one : panel.series) {
        if (!one.small) count += one.points.size();
    }
    return count;
}

std::vector<PlotPoint> one_at_each_x(const std::vector<PlotPoint>& points) {
    struct Place {
        std::vector<double> ys;
        double low;
        double high;
    };
    std::map<double, Place> places;
    for (const PlotPoint& point : points) {
        const double low = point.low.value_or(point.y);
        const double high = point.high.value_or(point.y);
        Place& place = places.try_emplace(point.x, Place{{}, low, high}).first->second;
        place.ys.push_back(point.y);
        place.low = std::min(place.low, low);
        place.high = std::max(place.high, high);
    }
    std::vector<PlotPoint> drawn;
    for (auto& [x, place] : places) {
        drawn.push_back({.x = x,
                         .y = *Percentiles{std::move(place.ys)}.at(0.5),
                         .low = place.low,
                         .high = place.high});
    }
    return drawn;
}

}  // namespace

std::string thin_out(Plot& plot) {
    std::size_t series = 0;
    bool are_medians = false;
    for (PlotPanel& panel : plot.panels) {
        series = std::max(series, panel.series.size());
        if (panel.series.size() > most_series) panel.series.resize(most_series);
        if (marks_in(panel) <= most_marks) continue;
        are_medians = true;
        for (PlotSeries& one : panel.series) {
            if (!one.small) one.points = one_at_each_x(one.points);
        }
    }
    std::string said;
    if (series > most_series) {
        said += " The first " + std::to_string(most_series) + " of " + std::to_string(series) +
                " series are drawn; <code>summary.csv</code> has all configurations.";
    }
    if (are_medians) {
        said +=
            " Where there are very many runs, a mark is their median and its bar reaches from the "
            "least to the most.";
    }
    return said;
}

}  // namespace romano::experiments
