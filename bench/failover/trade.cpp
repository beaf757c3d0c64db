#include "bench/failover/trade.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <utility>
#include <vector>

#include "bench/failover/bench.h"
#include "bench/failover/results.h"
#include "experiments/measure/percentile.h"
#include "experiments/report/plot.h"
#include "experiments/sweep/csv.h"

namespace romano::bench {
namespace {

struct Point {
    std::uint32_t timeout_ms;
    std::vector<double> failovers_ms;
    Watched watched;
};

Options with_timeout(const Options& options, std::uint32_t timeout_ms) {
    Options out = options;
    out.fault = Fault::silence;
    out.output = options.output / ("timeout-" + std::to_string(timeout_ms));
    out.broker_arguments.insert(out.broker_arguments.end(),
                                {"--detection-timeout-ms", std::to_string(timeout_ms)});
    return out;
}

Point measure(const Options& options, std::uint32_t timeout_ms,
              const std::function<bool()>& is_over) {
    Results results(options);
    Point point{.timeout_ms = timeout_ms, .failovers_ms = {}, .watched = {}};
    boost::asio::io_context io{1};
    Bench bench(io, options, results.traces());
    bench.start();
    while (results.trials().size() < options.trials) {
        results.add(bench.run(static_cast<std::uint32_t>(results.trials().size()) + 1));
    }
    for (const Trial& trial : results.trials()) {
        if (trial.total_ms) point.failovers_ms.push_back(*trial.total_ms);
    }
    if (options.watch_s > 0) {
        point.watched = bench.watch(std::chrono::seconds{options.watch_s}, is_over);
    }
    return point;
}

double false_failovers_per_hour(const Point& point) {
    if (point.watched.seconds <= 0) return 0;
    return static_cast<double>(point.watched.take_overs) * 3600 / point.watched.seconds;
}

const experiments::CsvRow& trade_head() {
    static const experiments::CsvRow row = {
        "detection_timeout_ms", "trials",         "failover_p50_ms", "failover_p99_ms",
        "failover_max_ms",      "watch_s",        "messages",        "lost",
        "suspicions",           "false_failovers"};
    return row;
}

void write_csv(const std::vector<Point>& points, const std::filesystem::path& file) {
    std::ofstream csv(file);
    csv << experiments::csv_line(trade_head());
    for (const Point& point : points) {
        const experiments::Percentiles p{point.failovers_ms};
        const auto number = [](double value) { return experiments::csv_number(value); };
        csv << experiments::csv_line(
            {std::to_string(point.timeout_ms), std::to_string(p.count()),
             number(p.at(0.5).value_or(0)), number(p.at(0.99).value_or(0)),
             number(p.max().value_or(0)), number(point.watched.seconds),
             std::to_string(point.watched.messages), std::to_string(point.watched.lost),
             std::to_string(point.watched.suspicions), std::to_string(point.watched.take_overs)});
    }
}

/// What an earlier call measured: the same folder, perhaps other timeouts.
std::vector<Point> read_points(const Options& options) {
    std::ifstream stream(options.output / "trade.csv");
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    std::vector<Point> points;
    for (const auto& row : experiments::parse_csv(text)) {
        if (row.size() != trade_head().size() || row == trade_head()) continue;
        const auto number = [&](std::size_t at) {
            return experiments::parse_csv_number(row[at]).value_or(0);
        };
        const auto count = [&](std::size_t at) { return static_cast<std::uint64_t>(number(at)); };
        Point point{.timeout_ms = static_cast<std::uint32_t>(count(0)),
                    .failovers_ms = {},
                    .watched = {.seconds = number(5),
                                .messages = count(6),
                                .lost = count(7),
                                .suspicions = count(8),
                                .take_overs = count(9)}};
        const Results results(with_timeout(options, point.timeout_ms));
        for (const Trial& trial : results.trials()) {
            if (trial.total_ms) point.failovers_ms.push_back(*trial.total_ms);
        }
        points.push_back(std::move(point));
    }
    return points;
}

experiments::Plot trade_figure(const std::vector<Point>& points) {
    experiments::PlotPanel speed{.title = "A silent broker is replaced",
                                 .x_label = "detection timeout (ms)",
                                 .y_label = "failover (ms)",
                                 .series = {},
                                 .y_from = 0};
    experiments::PlotPanel errors{.title = "A living broker is replaced",
                                  .x_label = "detection timeout (ms)",
                                  .y_label = "false failovers per hour, full load",
                                  .series = {},
                                  .y_from = 0};
    experiments::PlotSeries failovers{
        .label = "trials, line through the medians", .points = {}, .small = true};
    experiments::PlotSeries wrong{.label = {}, .points = {}};
    for (const Point& point : points) {
        const auto x = static_cast<double>(point.timeout_ms);
        for (const double ms : point.failovers_ms) failovers.points.push_back({.x = x, .y = ms});
        wrong.points.push_back({.x = x, .y = false_failovers_per_hour(point)});
    }
    speed.series.push_back(std::move(failovers));
    errors.series.push_back(std::move(wrong));
    return {.name = "trade", .panels = {std::move(speed), std::move(errors)}};
}

}  // namespace

bool run_trade(const Options& options, const std::function<bool()>& is_over) {
    std::vector<Point> points;
    if (!options.fresh) points = read_points(options);
    for (const std::uint32_t timeout_ms : options.timeouts_ms) {
        if (is_over()) return false;
        if (std::ranges::count(points, timeout_ms, &Point::timeout_ms) > 0) continue;
        Point measured = measure(with_timeout(options, timeout_ms), timeout_ms, is_over);
        if (is_over()) return false;  // its watch may have been cut short: not a point
        const Point& point = points.emplace_back(std::move(measured));
        const experiments::Percentiles p{point.failovers_ms};
        std::printf(
            "timeout %u ms: failover p50 %.1f ms, p99 %.1f ms; %llu false failovers in "
            "%.0f s of full load (%llu messages)\n",
            timeout_ms, p.at(0.5).value_or(0), p.at(0.99).value_or(0),
            static_cast<unsigned long long>(point.watched.take_overs), point.watched.seconds,
            static_cast<unsigned long long>(point.watched.messages));
        std::fflush(stdout);
        std::ranges::sort(points, {}, &Point::timeout_ms);
        write_csv(points, options.output / "trade.csv");
        if (const auto svg = experiments::draw(trade_figure(points), options.output)) {
            std::ofstream(options.output / "trade.svg") << *svg << '\n';
        }
    }
    return true;
}

}  // namespace romano::bench
