#include "experiments/loops/margins.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "experiments/loops/balance.h"
#include "experiments/loops/pendulum.h"
#include "experiments/measure/percentile.h"
#include "experiments/sweep/csv.h"
#include "overlay/sim/seed.h"

namespace romano::experiments {
namespace {

constexpr double most_delay_ms = 200;
constexpr double apart_ms = 10;
constexpr double within_ms = 0.5;

std::string file_of(const MarginsPlan& plan, std::uint16_t period_ms, double loss_percent) {
    return "margin_period" + std::to_string(period_ms) + "_loss" + csv_number(loss_percent) +
           "_poles" + std::to_string(plan.poles) + "_seconds" + csv_number(plan.seconds) + "_seed" +
           std::to_string(plan.seed);
}

Trial trial_of(const MarginsPlan& plan, std::uint16_t period_ms, double loss_percent,
               double delay_ms) {
    Trial trial{.delay_ms = delay_ms, .poles = loss_percent > 0 ? plan.poles : 1};
    std::uint64_t samples = 0;
    std::uint64_t commands = 0;
    for (std::size_t i = 0; i < trial.poles; ++i) {
        using Milliseconds = std::chrono::duration<double, std::milli>;
        const BalanceRun run = balance(
            plan.body,
            {.period_ms = period_ms,
             .delay = std::chrono::duration_cast<Duration>(Milliseconds{delay_ms}),
             .loss = loss_percent / 100,
             .seed = sim::seed_of(plan.seed, "pole", i),
             .lasts = std::chrono::duration_cast<Duration>(Milliseconds{plan.seconds * 1000})});
        trial.stay_up += run.stays_up ? 1 : 0;
        samples += run.samples;
        commands += run.commands;
    }
    trial.lost_percent = 100 * (1 - static_cast<double>(commands) / static_cast<double>(samples));
    return trial;
}

std::string to_csv(const Column& column) {
    std::string csv = csv_line({csv_number(column.mean_square_ms), csv_number(column.usual_ms)});
    for (const Trial& trial : column.trials) {
        csv += csv_line({csv_number(trial.delay_ms), std::to_string(trial.poles),
                         std::to_string(trial.stay_up), csv_number(trial.lost_percent)});
    }
    return csv;
}

Column column_in(const std::string& csv, std::uint16_t period_ms, double loss_percent) {
    const auto rows = parse_csv(csv);
    const auto number = [&](std::size_t row, std::size_t field) {
        return parse_csv_number(rows.at(row).at(field)).value();
    };
    Column column{.period_ms = period_ms,
                  .loss_percent = loss_percent,
                  .mean_square_ms = number(0, 0),
                  .usual_ms = number(0, 1),
                  .trials = {}};
    for (std::size_t i = 1; i < rows.size(); ++i) {
        column.trials.push_back({.delay_ms = number(i, 0),
                                 .poles = std::stoul(rows[i].at(1)),
                                 .stay_up = std::stoul(rows[i].at(2)),
                                 .lost_percent = number(i, 3)});
    }
    return column;
}

constexpr const char* words =
    R"(A cart of %M kg with a pole of %m kg and %l m on it, integrated in steps of 1 ms, and a law u = -k x on another robot
(k = %k: best for 50 samples a second without delay). Both talk through one broker's core. A round takes the delay
and is lost at random; the plant goes on as the last command said. Theory, from the linearised plant and k:
without losses, the delay at which a closed loop's eigenvalue leaves the unit circle; with losses, the one at which the
mean of the squares no longer dies away (second moments), and the one at which nearly every course of losses grows
("usual"); "theory" is the former. Found: the least delay, to 0.5 ms, at which one of %n poles (without losses: the one) does not stand straighter
after %t s than it began, at 0.3 to 0.9 degrees.)";

std::string words_of(const MarginsPlan& plan) {
    std::string text = words;
    const auto put = [&text](std::string_view name, const std::string& value) {
        text.replace(text.find(name), name.size(), value);
    };
    const auto gain = balancing_gain(plan.body);
    std::string k;
    for (const double number : gain) k += (k.empty() ? "" : ", ") + number_text(number, 1);
    put("%M", number_text(plan.body.cart_kg, 1));
    put("%m", number_text(plan.body.pole_kg, 1));
    put("%l", number_text(2 * plan.body.half_pole_m, 1));
    put("%k", k);
    put("%n", std::to_string(plan.poles));
    put("%t", number_text(plan.seconds, 0));
    return text;
}

PlotPanel panel_of(double loss_percent, const std::vector<Column>& columns) {
    PlotSeries up{.label = "all stay up", .points = {}, .line = false};
    PlotSeries some{.label = "some fall", .points = {}, .line = false};
    PlotSeries none{.label = "all fall", .points = {}, .line = false};
    PlotSeries mean_square{.label = "theory", .points = {}, .marked = false};
    PlotSeries usual{.label = "usual", .points = {}, .marked = false};
    for (const Column& column : columns) {
        if (column.loss_percent != loss_percent) continue;
        const double x = column.period_ms;
        for (const Trial& trial : column.trials) {
            PlotSeries& series = trial.stay_up == trial.poles ? up
                                 : trial.stay_up == 0         ? none
                                                              : some;
            series.points.push_back({.x = x, .y = trial.delay_ms});
        }
        mean_square.points.push_back({.x = x, .y = column.mean_square_ms});
        if (loss_percent > 0) usual.points.push_back({.x = x, .y = column.usual_ms});
    }
    return {.title = number_text(loss_percent, 0) + " % of the rounds lost",
            .x_label = "period (ms)",
            .y_label = "delay of a round (ms)",
            .series = {std::move(up), std::move(none), std::move(some), std::move(mean_square),
                       std::move(usual)},
            .y_from = 0};
}

}  // namespace

std::optional<double> Column::found_ms() const {
    const auto found =
        std::ranges::find_if(trials, [](const Trial& t) { return t.stay_up < t.poles; });
    if (found == trials.end()) return std::nullopt;
    return found->delay_ms;
}

Column column_of(const MarginsPlan& plan, std::uint16_t period_ms, double loss_percent) {
    const LinearPlant plant = linearised(plan.body);
    const auto gain = balancing_gain(plan.body);
    Column column{.period_ms = period_ms, .loss_percent = loss_percent, .trials = {}};
    const auto margin_ms = [&](Stability stability) {
        return 1000 * delay_margin_s(plant, gain, period_ms / 1000.0, loss_percent / 100, stability,
                                     most_delay_ms / 1000);
    };
    column.mean_square_ms = margin_ms(Stability::mean_square);
    column.usual_ms = margin_ms(Stability::usual);
    const auto tried = [&](double delay_ms) -> const Trial& {
        const auto place = std::ranges::lower_bound(column.trials, delay_ms, {}, &Trial::delay_ms);
        return *column.trials.insert(place, trial_of(plan, period_ms, loss_percent, delay_ms));
    };
    for (double delay_ms = 0; delay_ms <= most_delay_ms; delay_ms += apart_ms) {
        if (tried(delay_ms).stay_up == 0) break;
    }
    while (const auto found = column.found_ms()) {
        const auto above = std::ranges::find(column.trials, *found, &Trial::delay_ms);
        if (above == column.trials.begin()) break;
        const double below_ms = std::prev(above)->delay_ms;
        if (*found - below_ms <= within_ms) break;
        (void)tried((*found + below_ms) / 2);
    }
    return column;
}

std::optional<std::string> problem_with(const MarginsPlan& plan) {
    for (const std::uint16_t period_ms : plan.periods_ms) {
        const double window_ms = (control::PlantLoop::window - 1) * period_ms;
        if (window_ms >= most_delay_ms) continue;
        return "a period of " + std::to_string(period_ms) +
               " ms is too short: the delays that are "
               "tried, up to 200 ms, must be below 31 periods";
    }
    return std::nullopt;
}

std::vector<SeparateRun> runs_of(const MarginsPlan& plan) {
    std::vector<SeparateRun> runs;
    for (const double loss : plan.losses_percent) {
        for (const std::uint16_t period : plan.periods_ms) {
            runs.push_back({file_of(plan, period, loss), [plan, period, loss] {
                                return to_csv(column_of(plan, period, loss));
                            }});
        }
    }
    return runs;
}

Section margins_section(const MarginsPlan& plan, const std::filesystem::path& folder) {
    std::vector<Column> columns;
    for (const double loss : plan.losses_percent) {
        for (const std::uint16_t period : plan.periods_ms) {
            columns.push_back(
                column_in(outcome_of(file_of(plan, period, loss), folder), period, loss));
        }
    }
    SummaryTable margins{
        .head = {"loss", "period", "theory", "usual", "found", "difference", "difference", "lost"},
        .units = {"%", "ms", "ms", "ms", "ms", "ms", "%", "% seen"},
        .rows = {}};
    SummaryTable points{.head = {"loss", "period", "delay", "poles", "stay up", "lost"},
                        .units = {"%", "ms", "ms", "", "", "% seen"},
                        .rows = {}};
    for (const Column& column : columns) {
        const auto found = column.found_ms();
        Measured difference;
        Measured relative;
        if (found) difference = *found - column.mean_square_ms;
        if (found && column.mean_square_ms > 0) {
            relative = 100 * *difference / column.mean_square_ms;
        }
        std::vector<double> lost;  // where poles stood all the time
        for (const Trial& trial : column.trials) {
            if (trial.stay_up == trial.poles) lost.push_back(trial.lost_percent);
            points.rows.push_back({csv_number(column.loss_percent),
                                   std::to_string(column.period_ms), csv_number(trial.delay_ms),
                                   std::to_string(trial.poles), std::to_string(trial.stay_up),
                                   number_text(trial.lost_percent, 1)});
        }
        margins.rows.push_back({csv_number(column.loss_percent), std::to_string(column.period_ms),
                                number_text(column.mean_square_ms, 1),
                                number_text(column.usual_ms, 1), number_text(found, 1),
                                number_text(difference, 1), number_text(relative, 1),
                                number_text(Percentiles{std::move(lost)}.at(0.5), 1)});
    }
    Plot figure{.name = "margins", .panels = {}};
    for (const double loss : plan.losses_percent) figure.panels.push_back(panel_of(loss, columns));
    return {.title = "How much delay a balanced pole bears",
            .words = words_of(plan),
            .tables = {{"margins", std::move(margins)}, {"points", std::move(points), true}},
            .figure = std::move(figure)};
}

}  // namespace romano::experiments
