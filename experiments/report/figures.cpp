#include "experiments/report/figures.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "experiments/report/crowd.h"
#include "experiments/sweep/results_folder.h"

namespace romano::experiments {
namespace {

using Configurations = std::span<const Configuration>;
using Value = Measured RunRow::*;
using Number = std::function<double(const Cell&)>;

double brokers_of(const Cell& cell) {
    return cell.brokers;
}
double robots_of(const Cell& cell) {
    return cell.robots;
}
double rate_of(const Cell& cell) {
    return cell.rate_per_s;
}

std::vector<Configuration> those(Configurations all, const std::function<bool(const Cell&)>& is) {
    std::vector<Configuration> some;
    for (const Configuration& each : all) {
        if (!each.runs.empty() && is(each.cell())) some.push_back(each);
    }
    return some;
}

std::vector<Configuration> undisturbed(Configurations all) {
    return those(all, [](const Cell& cell) { return cell.fault == Fault::none; });
}

std::size_t distinct(Configurations all, const Number& number) {
    std::set<double> values;
    for (const Configuration& each : all) values.insert(number(each.cell()));
    return values.size();
}

/// One series for each combination of the other axes. When some reach over several x, those that
/// have one only are left out: they are the others' neighbours from another question.
std::vector<PlotSeries> series_over(const Number& x, Configurations all, Value y,
                                    std::span<const Axis> given, double scale = 1) {
    std::vector<PlotSeries> series;
    const AxisLabels labels{all};
    std::map<std::string, std::size_t> places;
    for (const Configuration& each : all) {
        const std::string label = labels.of(each.cell(), given);
        const auto [place, is_new] = places.try_emplace(label, series.size());
        if (is_new) series.push_back({.label = label, .points = {}});
        PlotSeries& found = series[place->second];
        for (const RunRow& run : each.runs) {
            if (run.*y) found.points.push_back({.x = x(run.cell), .y = *(run.*y) * scale});
        }
    }
    const auto reaches = [](const PlotSeries& one) {
        return std::ranges::any_of(one.points,
                                   [&](const PlotPoint& p) { return p.x != one.points.front().x; });
    };
    if (std::ranges::any_of(series, reaches)) {
        std::erase_if(series, [&](const PlotSeries& one) { return !reaches(one); });
    }
    std::erase_if(series, [](const PlotSeries& one) { return one.points.empty(); });
    // One broker has no elector, detector, acks: nothing else can be said of it.
    for (PlotSeries& one : series) {
        if (series.size() > 1 && one.label.empty()) one.label = "1 broker";
    }
    return series;
}

void prefix_labels(std::vector<PlotSeries>& series, const std::string& word) {
    for (PlotSeries& one : series) one.label = one.label.empty() ? word : word + ", " + one.label;
}

void append(std::vector<PlotSeries>& series, std::vector<PlotSeries> more) {
    series.insert(series.end(), std::make_move_iterator(more.begin()),
                  std::make_move_iterator(more.end()));
}

/// Not on top of each other, where one would cover the others. The last is still nearer to its own
/// x than to the next.
void set_beside_each_other(std::vector<PlotSeries>& series) {
    const double step = std::min(0.06, 0.4 / static_cast<double>(series.size()));
    for (std::size_t i = 0; i < series.size(); ++i) {
        for (PlotPoint& point : series[i].points) point.x += step * static_cast<double>(i);
    }
}

/// A mark a run, with a bar from `low` to `high` where the run has them.
std::vector<PlotSeries> marks_over_brokers(Configurations struck, Value y, Value low, Value high) {
    constexpr std::array given = {Axis::brokers};
    std::vector<PlotSeries> series;
    const AxisLabels labels{struck};
    std::map<std::string, std::size_t> places;
    for (const Configuration& each : struck) {
        const std::string label = labels.of(each.cell(), given);
        const auto [place, is_new] = places.try_emplace(label, series.size());
        if (is_new) series.push_back({.label = label, .points = {}, .line = false});
        PlotSeries& found = series[place->second];
        for (const RunRow& run : each.runs) {
            if (!(run.*y)) continue;
            found.points.push_back({.x = brokers_of(run.cell),
                                    .y = *(run.*y),
                                    .low = low == nullptr ? std::nullopt : run.*low,
                                    .high = high == nullptr ? std::nullopt : run.*high});
        }
    }
    set_beside_each_other(series);
    return series;
}

std::vector<RunRow> runs_of(Configurations all) {
    std::vector<RunRow> runs;
    for (const Configuration& each : all) {
        runs.insert(runs.end(), each.runs.begin(), each.runs.end());
    }
    return runs;
}

std::optional<Figure> failover_figure(Configurations all, double probe_per_s) {
    constexpr std::array given = {Axis::brokers};
    const auto struck = those(all, [](const Cell& cell) { return cell.fault != Fault::none; });
    if (struck.empty()) return std::nullopt;
    PlotPanel probe{
        .title = "Until the address serves again",
        .x_label = "brokers",
        .y_label = "ms after the fault, by the probe",
        .series = marks_over_brokers(struck, &RunRow::failover_probe_ms, nullptr, nullptr),
        .y_from = 0};
    PlotPanel clients{
        .title = "Until robots hear again",
        .x_label = "brokers",
        .y_label = "ms after the fault",
        .series = marks_over_brokers(struck, &RunRow::failover_p50_ms, &RunRow::failover_first_ms,
                                     &RunRow::failover_last_ms),
        .y_from = 0};
    PlotPanel leader{.title = "Without a leader",
                     .x_label = "brokers",
                     .y_label = "ms after the leader's death",
                     .series = series_over(brokers_of, struck, &RunRow::without_leader_ms, given),
                     .y_from = 0};
    Figure figure{
        .title = "Failover time against the number of brokers",
        .plot = {.name = "failover", .panels = {}},
        .shows =
            "Robots: each bar is one run, from the first to the last client of the broker that was "
            "struck; the mark is the median client.",
        .measured =
            "From <code>kill -9</code> (or SIGSTOP) of a broker to the first message, published "
            "after that moment, that reaches a client of that broker. The client keeps its socket "
            "and its broker's address. A broker is declared dead only after its detection time, "
            "which is part of these numbers. <b>Resolution:</b> robots hear at the pace of their "
            "schedule, a message of each publisher every " +
            publishing_interval_of(runs_of(struck)) +
            "; within that, their times tell the schedule, not the brokers."};
    const auto probed = [](const PlotSeries& one) { return !one.points.empty(); };
    if (std::ranges::any_of(probe.series, probed)) {
        figure.shows =
            "The probe: each mark is one run, the time until the struck broker's address served "
            "again. " +
            figure.shows;
        figure.measured +=
            " The probe, a publisher and a subscriber at each broker, has a message "
            "every " +
            csv_number(1e3 / probe_per_s) + " ms, and is as fine as that.";
    }
    if (!leader.series.empty()) {
        figure.measured +=
            " Without a leader: from the leader's death until the last surviving broker tells its "
            "clients, on <code>$SYS/brokers</code>, of a new living one.";
    }
    figure.plot.panels = {std::move(probe), std::move(clients), std::move(leader)};
    return figure;
}

std::optional<Figure> around_a_fault_figure(Configurations all, double fault_after_s,
                                            const std::filesystem::path& results) {
    // The first run with the most brokers whose leader was killed; else any with a fault.
    const RunRow* shown = nullptr;
    for (const Configuration& each : all) {
        for (const RunRow& run : each.runs) {
            if (run.cell.fault == Fault::none) continue;
            const auto weight = [](const RunRow& row) {
                return std::pair{row.cell.fault == Fault::kill_leader, row.cell.brokers};
            };
            if (shown == nullptr || weight(run) > weight(*shown)) shown = &run;
        }
    }
    if (shown == nullptr) return std::nullopt;
    PlotPanel panel{.title = std::to_string(shown->cell.brokers) + " brokers",
                    .x_label = "time of publishing (s)",
                    .y_label = "delay until delivery (ms)",
                    .series = {},
                    .log_y = true,
                    .ticks_at_points = false,
                    .y_from = 0.01,
                    .marked_x = fault_after_s,
                    .marked_label = std::string{name_of(shown->cell.fault)}};
    for (int qos = 0; qos <= 2; ++qos) {
        panel.series.push_back(
            {.label = "QoS " + std::to_string(qos), .points = {}, .line = false, .small = true});
    }
    // Of a run that lasts for minutes, the first fault: nobody can open a page of a million marks.
    constexpr double shown_before_s = 5;
    constexpr double shown_after_s = 10;
    for (const Sample& sample : read_samples(results, shown->cell)) {
        const double since_fault_s = sample.sent_s - fault_after_s;
        if (since_fault_s < -shown_before_s || since_fault_s > shown_after_s) continue;
        if (!sample.delay_ms) continue;
        panel.series[sample.qos].points.push_back({.x = sample.sent_s, .y = *sample.delay_ms});
    }
    std::erase_if(panel.series, [](const PlotSeries& one) { return one.points.empty(); });
    if (panel.series.empty()) return std::nullopt;
    return Figure{.title = "What a fault looks like",
                  .plot = {.name = "around_a_fault", .panels = {std::move(panel)}},
                  .shows =
                      "Every delivered message of one run, from 5 s before its fault, the first of "
                      "several, until 10 s after it. Those published while the broker is "
                      "missing wait until another has taken its address over: the slope is "
                      "the time that they waited.",
                  .measured = "Cell " + std::to_string(shown->cell.number) + " of this sweep (" +
                              describe(shown->cell) + "), from its raw samples."};
}

std::optional<Figure> delay_figure(Configurations all) {
    const auto calm = undisturbed(all);
    if (calm.empty()) return std::nullopt;
    // Where only the rate varies, the figure of the rate shows the delay.
    if (distinct(calm, robots_of) < 2 && distinct(calm, rate_of) > 1) return std::nullopt;
    const bool over_brokers = distinct(calm, robots_of) < 2;
    const Number x = over_brokers ? brokers_of : robots_of;
    const std::string x_name = over_brokers ? "brokers" : "robots";
    const std::array given = {over_brokers ? Axis::brokers : Axis::robots, Axis::fault};
    const auto panel = [&](const char* title, Value middle, Value tail) {
        PlotPanel made{.title = title,
                       .x_label = x_name,
                       .y_label = "ms",
                       .series = series_over(x, calm, middle, given),
                       .y_from = 0};
        prefix_labels(made.series, "median");
        auto tails = series_over(x, calm, tail, given);
        prefix_labels(tails, "99 %");
        append(made.series, std::move(tails));
        if (distinct(calm, x) < 2) set_beside_each_other(made.series);
        return made;
    };
    return Figure{
        .title = "Delay against the number of " + x_name,
        .plot = {.name = "delay",
                 .panels = {panel("To each receiver", &RunRow::delay_p50_ms, &RunRow::delay_p99_ms),
                            panel("To the last of a group", &RunRow::fan_out_p50_ms,
                                  &RunRow::fan_out_p99_ms)}},
        .shows =
            "Left, every delivery counts; right, a group message counts when the last "
            "subscriber has it. Runs without a fault.",
        .measured =
            "From the publisher's application to the subscriber's application: both ends are in "
            "the process that drives the robots, so one clock times both. QoS 1 and 2 include the "
            "wait until a peer holds the event (<code>acks</code>)."};
}

/// One scale for all: down to 99 %, or to the lowest; nothing is delivered beyond 100 %.
void set_ratio_scale(std::span<PlotPanel> panels) {
    double lowest = 100;
    for (const PlotPanel& panel : panels) {
        for (const PlotSeries& one : panel.series) {
            for (const PlotPoint& point : one.points) lowest = std::min(lowest, point.y);
        }
    }
    for (PlotPanel& panel : panels) {
        panel.y_from = std::min(99.0, lowest - (100 - lowest) * 0.2);
        panel.y_to = 100 + (100 - *panel.y_from) * 0.04;  // so that 100 % is not the frame
    }
}

std::optional<Figure> delivery_figure(Configurations all) {
    // A level is its own name; a mix is told apart from other mixes.
    const bool has_mixes = std::ranges::any_of(
        all, [](const Configuration& each) { return each.cell().qos.text().size() > 1; });
    std::vector<Axis> given = {Axis::brokers, Axis::fault};
    if (!has_mixes) given.push_back(Axis::qos);
    std::vector<PlotPanel> panels;
    std::set<Fault> faults;
    for (const Configuration& each : all) faults.insert(each.cell().fault);
    for (const Fault fault : faults) {
        const auto some = those(all, [fault](const Cell& cell) { return cell.fault == fault; });
        if (some.empty()) continue;
        PlotPanel panel{.title = fault == Fault::none ? "No fault" : std::string{name_of(fault)},
                        .x_label = "brokers",
                        .y_label = "delivered of expected (%)",
                        .series = {}};
        const std::array<std::pair<const char*, Value>, 3> levels{{
            {"QoS 0", &RunRow::delivery_ratio_qos0},
            {"QoS 1", &RunRow::delivery_ratio_qos1},
            {"QoS 2", &RunRow::delivery_ratio_qos2},
        }};
        for (const auto& [name, value] : levels) {
            auto series = series_over(brokers_of, some, value, given, 100);
            prefix_labels(series, name);
            append(panel.series, std::move(series));
        }
        set_beside_each_other(panel.series);
        panels.push_back(std::move(panel));
    }
    if (panels.empty()) return std::nullopt;
    set_ratio_scale(panels);
    return Figure{
        .title = "Delivery ratio",
        .plot = {.name = "delivery", .panels = std::move(panels)},
        .shows =
            "QoS 0 promises nothing, and what is on its way when a broker dies is gone. An "
            "acknowledged QoS 1 or 2 message must arrive, whatever happens: see "
            "<em>acknowledged but lost</em> in the table.",
        .measured =
            "Expected is one delivery for each message and each robot subscribed to its "
            "topic, until the end of the run and its drain time. Copies count once."};
}

std::optional<Figure> rate_figure(Configurations all, World world) {
    const auto calm = undisturbed(all);
    if (distinct(calm, rate_of) < 2) return std::nullopt;
    constexpr std::array given = {Axis::rate, Axis::fault};
    PlotPanel ratio{.title = "Delivery ratio",
                    .x_label = "messages per second and publisher",
                    .y_label = "delivered of expected (%)",
                    .series = series_over(rate_of, calm, &RunRow::delivery_ratio, given, 100)};
    set_ratio_scale({&ratio, 1});
    PlotPanel delay{.title = "Delay, 99 %",
                    .x_label = "messages per second and publisher",
                    .y_label = "ms",
                    .series = series_over(rate_of, calm, &RunRow::delay_p99_ms, given),
                    .y_from = 0};
    return Figure{
        .title = "Against the message rate",
        .plot = {.name = "rate", .panels = {std::move(ratio), std::move(delay)}},
        .shows =
            "The question of the ROMANO paper's table of delivery ratios: how many messages "
            "a second go through.",
        .measured =
            "Runs without a fault; otherwise as in the figures above." +
            std::string{is_on_radio(world)
                            ? ""
                            : " There is no radio in them: the paper's lost messages beyond 200 a "
                              "second."}};
}

std::optional<Figure> overhead_figure(Configurations all) {
    const auto calm = undisturbed(all);
    if (calm.empty()) return std::nullopt;
    constexpr std::array given = {Axis::brokers, Axis::fault};
    const bool has_processes = std::ranges::any_of(calm, [](const Configuration& each) {
        return !each.values(&RunRow::broker_cpu_percent_mean).empty();
    });
    const auto panel = [&](const char* title, const char* unit, Value value, double scale) {
        return PlotPanel{.title = title,
                         .x_label = "brokers",
                         .y_label = unit,
                         .series = series_over(brokers_of, calm, value, given, scale),
                         .y_from = 0};
    };
    return Figure{.title = "Overhead against the number of brokers",
                  .plot = {.name = "overhead",
                           .panels = {panel("Between brokers, all together", "kB/s",
                                            &RunRow::interbroker_octets_per_s, 1e-3),
                                      panel("CPU of a broker, mean", "% of one core",
                                            &RunRow::broker_cpu_percent_mean, 1),
                                      panel("Memory of a broker, mean peak", "MiB",
                                            &RunRow::broker_rss_peak_mib_mean, 1)}},
                  .shows = "What replication costs while nothing goes wrong.",
                  .measured =
                      "Octets that the brokers hand to DDS for their peers, by their own count on "
                      "<code>$SYS/brokers</code>: without the headers of RTPS and UDP." +
                      std::string{has_processes ? " CPU time and peak resident memory (VmHWM) from "
                                                  "<code>/proc</code>, within the load."
                                                : ""}};
}

/// Of the first run that was long enough to tell.
std::optional<Figure> memory_figure(Configurations all, const std::filesystem::path& results) {
    constexpr double long_enough_s = 120;
    for (const Configuration& each : all) {
        for (const RunRow& run : each.runs) {
            const auto samples = read_memory(results, run.cell);
            if (samples.empty() || samples.back().at_s < long_enough_s) continue;
            PlotPanel panel{.title = std::string{name_of(run.cell.fault)},
                            .x_label = "time (minutes)",
                            .y_label = "resident memory of a broker (MiB)",
                            .series = {},
                            .ticks_at_points = false,
                            .y_from = 0};
            for (const MemorySample& sample : samples) {
                auto found = std::ranges::find(panel.series, sample.broker, &PlotSeries::label);
                if (found == panel.series.end()) {
                    found = panel.series.insert(
                        found,
                        {.label = sample.broker, .points = {}, .line = false, .small = true});
                }
                found->points.push_back({.x = sample.at_s / 60, .y = sample.rss_mib});
            }
            return Figure{.title = "Memory over time",
                          .plot = {.name = "memory", .panels = {std::move(panel)}},
                          .shows =
                              "Each broker, once a second. A broker that is started again "
                              "begins anew.",
                          .measured = "Cell " + std::to_string(run.cell.number) +
                                      " of this sweep (" + describe(run.cell) +
                                      "); VmRSS from <code>/proc</code>."};
        }
    }
    return std::nullopt;
}

}  // namespace

std::string publishing_interval_of(std::span<const RunRow> runs) {
    if (runs.empty()) return "";
    const auto [slowest, fastest] =
        std::ranges::minmax(runs, {}, [](const RunRow& run) { return run.cell.rate_per_s; });
    const std::string shortest = csv_number(1e3 / fastest.cell.rate_per_s);
    if (slowest.cell.rate_per_s == fastest.cell.rate_per_s) return shortest + " ms";
    return shortest + " to " + csv_number(1e3 / slowest.cell.rate_per_s) + " ms";
}

std::vector<Figure> figures_of(Configurations configurations, const SweepSettings& settings,
                               const std::filesystem::path& results) {
    std::vector<Figure> figures;
    const auto add = [&figures](std::optional<Figure> figure) {
        if (!figure || one_by_one(figure->plot).empty()) return;
        figure->shows += thin_out(figure->plot);
        figures.push_back(std::move(*figure));
    };
    add(failover_figure(configurations, settings.probe_per_s));
    add(around_a_fault_figure(configurations, settings.fault_after.count(), results));
    add(delivery_figure(configurations));
    add(delay_figure(configurations));
    add(rate_figure(configurations, settings.world));
    add(overhead_figure(configurations));
    add(memory_figure(configurations, results));
    return figures;
}

}  // namespace romano::experiments
