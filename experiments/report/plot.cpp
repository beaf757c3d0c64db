#include "experiments/report/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string_view>

#include "experiments/measure/percentile.h"
#include "experiments/process/program.h"

namespace romano::experiments {
namespace {

/// Okabe and Ito's colours: told apart by colour-blind readers too.
constexpr std::array colours = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                "#E69F00", "#56B4E9", "#555555"};
constexpr std::array marks = {7, 5, 9, 13, 11, 15, 6};

std::string quoted(const std::string& text) {
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') quoted += '\\';
        quoted += c == '\n' ? ' ' : c;
    }
    return quoted + '"';
}

std::vector<PlotPoint> medians_of(const PlotSeries& series) {
    std::map<double, std::vector<double>> at;
    for (const PlotPoint& point : series.points) at[point.x].push_back(point.y);
    std::vector<PlotPoint> medians;
    medians.reserve(at.size());
    for (auto& [x, ys] : at) {
        medians.push_back({.x = x, .y = *Percentiles{std::move(ys)}.at(0.5)});
    }
    return medians;
}

bool has_points(const PlotPanel& panel) {
    return std::ranges::any_of(panel.series,
                               [](const PlotSeries& one) { return !one.points.empty(); });
}

std::vector<PlotPanel> with_points(const std::vector<PlotPanel>& panels) {
    std::vector<PlotPanel> some;
    std::ranges::copy_if(panels, std::back_inserter(some), has_points);
    return some;
}

// In gnuplot's units of the SVG terminal.
constexpr std::size_t panel_width = 480;
constexpr std::size_t panel_height = 370;  // without its key
constexpr std::size_t line_height = 21;
// In characters of the key: what fits below a panel, and what an entry takes beside its label.
// Found by drawing, as gnuplot does not say how many columns it will make; a column more than it
// makes, and the key covers the axis.
constexpr double key_width = 42.5;
constexpr double beside_label = 4.5;

/// A longer label goes on in the next row: gnuplot would draw it beyond the edge.
constexpr std::size_t label_width = 40;

bool begins_character(char octet) {  // of UTF-8
    return (static_cast<unsigned char>(octet) & 0xC0U) != 0x80U;
}

std::size_t characters_of(std::string_view text) {
    return static_cast<std::size_t>(std::ranges::count_if(text, begins_character));
}

/// The rows of a label, broken between words, and within a word that is longer than a row.
std::vector<std::string> rows_of(const std::string& label) {
    std::vector<std::string> rows(1);
    std::size_t used = 0;  // characters of the last row
    const auto begin_row = [&] {
        rows.emplace_back();
        used = 0;
    };
    std::istringstream words(label);
    for (std::string word; words >> word;) {
        if (used != 0 && used + 1 + characters_of(word) > label_width) begin_row();
        if (used != 0) {
            rows.back() += ' ';
            ++used;
        }
        for (const char octet : word) {
            if (begins_character(octet)) {
                if (used == label_width) begin_row();
                ++used;
            }
            rows.back() += octet;
        }
    }
    return rows;
}

/// The key stands below its panel, and gets the room that it needs there: of a panel with many
/// series, gnuplot would draw it over the axis. One layout for all, so that the axes are level.
struct KeyLayout {
    std::size_t columns = 1;
    std::size_t rows = 0;
};

KeyLayout key_of(const std::vector<PlotPanel>& panels) {
    std::size_t entries = 0;
    std::size_t longest = 1;
    for (const PlotPanel& panel : panels) {
        std::size_t labelled = 0;
        for (const PlotSeries& one : panel.series) {
            if (one.label.empty() || one.points.empty()) continue;
            for (const std::string& row : rows_of(one.label)) {
                ++labelled;
                longest = std::max(longest, characters_of(row));
            }
        }
        entries = std::max(entries, labelled);
    }
    const double fit = key_width / (static_cast<double>(longest) + beside_label);
    const std::size_t columns = std::max<std::size_t>(static_cast<std::size_t>(fit), 1);
    return {.columns = columns, .rows = (entries + columns - 1) / columns};
}

std::string block_name(std::size_t panel, std::size_t series, const char* what) {
    return "$p" + std::to_string(panel) + "s" + std::to_string(series) + what;
}

void write_blocks(const PlotPanel& panel, std::size_t number, std::ostream& out) {
    for (std::size_t i = 0; i < panel.series.size(); ++i) {
        out << block_name(number, i, "runs") << " << EOD\n";
        for (const PlotPoint& point : panel.series[i].points) {
            out << point.x << ' ' << point.y << ' ' << point.low.value_or(point.y) << ' '
                << point.high.value_or(point.y) << '\n';
        }
        out << "EOD\n" << block_name(number, i, "line") << " << EOD\n";
        for (const PlotPoint& point : medians_of(panel.series[i])) {
            out << point.x << ' ' << point.y << '\n';
        }
        out << "EOD\n";
    }
}

void write_x_axis(const PlotPanel& panel, std::ostream& out) {
    std::set<long> places;
    double low = 1e300;
    double high = -1e300;
    for (const PlotSeries& series : panel.series) {
        for (const PlotPoint& point : series.points) {
            places.insert(std::lround(point.x));
            low = std::min(low, point.x);
            high = std::max(high, point.x);
        }
    }
    if (low > high) return;
    if (!panel.ticks_at_points) {
        out << "set xtics auto\nset xrange [*:*]\n";
        return;
    }
    const double margin = std::max((high - low) * 0.08, 0.5);
    out << "set xrange [" << low - margin << ":" << high + margin << "]\nset xtics (";
    // Ticks that would run into each other are left out.
    long last = 0;
    bool first = true;
    for (const long place : places) {
        if (!first && static_cast<double>(place - last) < (high - low) / 14) continue;
        out << (first ? "" : ", ") << '"' << place << "\" " << place;
        last = place;
        first = false;
    }
    out << ")\n";
}

void write_panel(const PlotPanel& panel, std::size_t number, std::ostream& out) {
    out << "set title " << quoted(panel.title) << "\nset xlabel " << quoted(panel.x_label)
        << "\nset ylabel " << quoted(panel.y_label) << '\n'
        << (panel.log_y ? "set logscale y 10\n" : "unset logscale\n") << "set yrange ["
        << (panel.y_from ? std::to_string(*panel.y_from) : "*") << ':'
        << (panel.y_to ? std::to_string(*panel.y_to) : "*") << "]\n";
    write_x_axis(panel, out);
    out << (panel.is_map ? "set size ratio -1\n" : "set size noratio\n");
    out << "unset arrow\nunset label\n";
    if (panel.marked_x) {
        out << "set arrow from " << *panel.marked_x << ", graph 0 to " << *panel.marked_x
            << ", graph 1 nohead lc rgb '#888888' dt 2\nset label " << quoted(panel.marked_label)
            << " at " << *panel.marked_x << ", graph 0.95 offset 0.6,0 tc rgb '#555555'\n";
    }
    std::string separator = "plot ";
    for (std::size_t i = 0; i < panel.series.size(); ++i) {
        const PlotSeries& series = panel.series[i];
        if (series.points.empty()) continue;
        const char* colour = colours[i % colours.size()];
        const int mark =
            marks[(i + i / colours.size()) % marks.size()];  // no pair comes twice soon
        const bool bars = std::ranges::any_of(series.points,
                                              [](const PlotPoint& p) { return p.low.has_value(); });
        const auto part = [&](const std::string& text) {
            out << separator << text;
            separator = ", \\\n     ";
        };
        std::ostringstream style;
        style << "lc rgb '" << colour << "' ";
        const std::vector<std::string> rows = rows_of(series.label);
        const std::string title = series.label.empty() ? " notitle" : " title " + quoted(rows[0]);
        const auto go_on_in_key = [&] {
            for (std::size_t row = 1; row < rows.size(); ++row) {
                part("keyentry title " + quoted(rows[row]));
            }
        };
        if (series.line) {
            part(block_name(number, i, "line") + " using 1:2 with lines lw 1.6 " + style.str() +
                 (series.marked ? " notitle" : title));
        }
        if (!series.marked) {
            go_on_in_key();
            continue;
        }
        style << "pt " << mark << " ps " << (series.small ? 0.25 : 0.75);
        part(block_name(number, i, "runs") +
             (bars ? " using 1:2:3:4 with yerrorbars lw 1.6 " : " using 1:2 with points ") +
             style.str() + title);
        go_on_in_key();
    }
    out << '\n';
}

}  // namespace

std::vector<Plot> one_by_one(const Plot& plot) {
    std::vector<Plot> plots;
    for (const PlotPanel& panel : with_points(plot.panels)) {
        plots.push_back(
            {.name = plot.name + "_" + std::to_string(plots.size() + 1), .panels = {panel}});
    }
    if (plots.size() == 1) plots.front().name = plot.name;
    return plots;
}

std::string gnuplot_script(const Plot& plot) {
    const std::vector<PlotPanel> panels = with_points(plot.panels);
    const std::size_t columns = std::clamp<std::size_t>(panels.size(), 1, 3);
    const std::size_t rows = (panels.size() + columns - 1) / columns;
    const KeyLayout key = key_of(panels);
    std::ostringstream out;
    out.precision(9);
    out << "# Draw with: gnuplot " << plot.name << ".gp > " << plot.name << ".svg\n"
        << "set terminal svg size " << panel_width * columns << ','
        << (panel_height + line_height * key.rows) * rows
        << " dynamic noenhanced font 'sans-serif,13' name '" << plot.name << "'\n"
        << "set encoding utf8\nset border 3 lc rgb '#666666'\nset tics nomirror out\n"
        << "set grid ytics lc rgb '#dddddd' lt 1 lw 0.6\nset style data points\n"
        << "set key below center horizontal maxcols " << key.columns
        << " reverse Left samplen 1 spacing 1.15 font ',12'\n"
        << "set lmargin 12\nset rmargin 3\nset tmargin 2.5\nset bmargin "
        << 3.9 + 1.08 * static_cast<double>(key.rows)
        << "\nset offsets graph 0, graph 0, graph 0.06, graph 0.02\nset errorbars 0.6\n";
    for (std::size_t i = 0; i < panels.size(); ++i) write_blocks(panels[i], i, out);
    if (panels.size() > 1) {
        out << "set multiplot layout " << rows << ',' << columns << "\n";
    }
    for (std::size_t i = 0; i < panels.size(); ++i) write_panel(panels[i], i, out);
    if (panels.size() > 1) out << "unset multiplot\n";
    return out.str();
}

std::optional<std::string> draw(const Plot& plot, const std::filesystem::path& script_folder) {
    if (with_points(plot.panels).empty()) return std::nullopt;
    std::error_code failed;
    std::filesystem::create_directories(script_folder, failed);
    const auto script = script_folder / (plot.name + ".gp");
    std::ofstream(script) << gnuplot_script(plot);

    const std::string svg = run_program("gnuplot", {script.string()}).output;
    const std::size_t begin = svg.find("<svg");  // behind the XML declaration
    if (begin == std::string::npos || svg.find("</svg>") == std::string::npos) return std::nullopt;
    return svg.substr(begin);
}

}  // namespace romano::experiments
