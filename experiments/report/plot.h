// A plot as data, drawn by gnuplot as SVG. The gnuplot script is kept beside the report, with the
// numbers in it, so that anybody can draw it another way.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace romano::experiments {

struct PlotPoint {
    double x = 0;
    double y = 0;
    std::optional<double> low = std::nullopt;  // with high: a bar around y
    std::optional<double> high = std::nullopt;
};

struct PlotSeries {
    std::string label;              // empty: not in the key
    std::vector<PlotPoint> points;  // one a run, in any order
    bool line = true;               // through the median of the points at each x
    bool small = false;             // a cloud of many points
    bool marked = true;             // else the line alone
};

struct PlotPanel {
    std::string title;
    std::string x_label;
    std::string y_label;
    std::vector<PlotSeries> series;
    bool log_y = false;
    bool ticks_at_points = true;  // of x: where there is something to see
    bool is_map = false;          // x and y in one unit: one scale for both
    std::optional<double> y_from = std::nullopt;
    std::optional<double> y_to = std::nullopt;
    std::optional<double> marked_x = std::nullopt;  // a vertical line: the fault
    std::string marked_label = {};
};

struct Plot {
    std::string name;               // of its script and of the SVG's parts: letters, digits, _
    std::vector<PlotPanel> panels;  // three in a row; those without a point are left out
};

/// Each panel with a point as a plot of its own, for pages whose width is not known: "delay_1"...
[[nodiscard]] std::vector<Plot> one_by_one(const Plot& plot);

[[nodiscard]] std::string gnuplot_script(const Plot& plot);

/// The <svg> element. Empty when gnuplot is not there or fails, or there is no point at all.
[[nodiscard]] std::optional<std::string> draw(const Plot& plot,
                                              const std::filesystem::path& script_folder);

}  // namespace romano::experiments
