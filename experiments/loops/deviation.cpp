#include "experiments/loops/deviation.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <numbers>
#include <stdexcept>

#include "experiments/loops/loop_robot.h"
#include "experiments/loops/pendulum.h"
#include "experiments/loops/spread.h"
#include "experiments/sweep/csv.h"
#include "overlay/sim/seed.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr std::uint16_t period_ms = 20;
constexpr double wind_nm = 0.05;
constexpr Duration waited_for = 60s;  // several Tretry: on radio, CONNECT may be lost, too
constexpr Duration blown_before = 3s;
constexpr Duration looked_at = 5s;
constexpr Duration course_before = 500ms;
constexpr Duration course_each = 20ms;
constexpr double target = 1.1;

using Milliseconds = std::chrono::duration<double, std::milli>;

double degrees(double radians) {
    return radians * 180 / std::numbers::pi;
}

}  // namespace

DeviationRun deviate(const CartPoleBody& body, const DeviationCase& setting) {
    const std::uint64_t seed = setting.seed;
    const auto around = make_brokers(setting.ground, setting.brokers, seed);
    Pendulum pendulum(body, {}, {.strength_nm = wind_nm, .seed = sim::seed_of(seed, "wind")});
    Balancer balancer(balancing_gain(body));
    LoopRobot cart(around->surroundings(), seed, 1, around->address_of(0), pendulum);
    LoopRobot law(around->surroundings(), seed, 2, around->address_of(0), balancer);
    cart.start();
    law.start();
    law.open(cart.id(), law.id(),
             {.period_ms = period_ms,
              .deadline_ms = deadline_ms_for(setting.ground.world, period_ms),
              .fallback = control::Fallback::stop});
    if (!around->run_until([&] { return cart.is_controlled(); }, waited_for)) {
        throw std::runtime_error("the pendulum's loop did not begin within a minute");
    }
    pendulum.release(around->now());
    Random random(sim::seed_of(seed, "strike"));
    around->run_for(blown_before + random.between(0s, 1s));

    DeviationRun run;
    const auto follow = [&](Duration time) {
        for (const Instant end = around->now() + time; around->now() < end;) {
            run.course_deg.push_back(degrees(pendulum.state().angle_rad));
            around->run_for(course_each);
            pendulum.move_on(around->now());
        }
    };
    follow(course_before);
    const control::LoopCounters before = cart.loop().counters();
    const std::uint32_t falls_before = pendulum.falls_back();
    pendulum.forget_angle();
    cart.watch();
    around->strike(setting.fault);
    pendulum.shove(around->now(),
                   random.below(2) == 0 ? setting.shove_rad_s : -setting.shove_rad_s);
    if (setting.fault == BrokerFault::roaming) {
        cart.roam_to(around->address_of(1));
        law.roam_to(around->address_of(1));
    }
    follow(looked_at);
    const control::LoopCounters& counters = cart.loop().counters();
    if (!pendulum.has_fallen()) run.angle_deg = degrees(pendulum.greatest_angle_rad());
    run.falls_back = pendulum.falls_back() - falls_before;
    run.age_ms = Milliseconds{cart.greatest_age()}.count();
    const std::uint32_t samples = counters.samples - before.samples;
    const std::uint32_t commands = counters.accepted - before.accepted;
    run.lost = samples - std::min(samples, commands);  // one command may be on its way
    const bool is_led = around->run_until([&] { return cart.is_controlled(); }, waited_for);
    if (is_led) run.wait_ms = Milliseconds{cart.longest_wait()}.count();
    return run;
}

namespace {

std::string file_of(const DeviationPlan& plan, LoopWorld world, const Kind& kind) {
    return "deviation_" + std::string{name_of(world)} + "_brokers" + std::to_string(kind.brokers) +
           "_fault" + std::to_string(static_cast<int>(kind.fault)) + "_shove" +
           csv_number(plan.shove_rad_s) + "_runs" + std::to_string(plan.runs) + "_seed" +
           std::to_string(plan.seed);
}

/// The course of the first one alone.
std::string outcome(const DeviationPlan& plan, const LoopGround& ground, const Kind& kind) {
    std::string csv;
    CsvRow course;
    for (std::size_t i = 0; i < plan.runs; ++i) {
        const DeviationRun run =
            deviate(plan.body, {.ground = ground,
                                .brokers = kind.brokers,
                                .fault = kind.fault,
                                .shove_rad_s = plan.shove_rad_s,
                                .seed = sim::seed_of(plan.seed, "deviation", i)});
        csv += csv_line({run.angle_deg ? csv_number(*run.angle_deg) : "",
                         std::to_string(run.falls_back), csv_number(run.age_ms),
                         std::to_string(run.lost), run.wait_ms ? csv_number(*run.wait_ms) : ""});
        if (i > 0) continue;
        for (const double deg : run.course_deg) course.push_back(csv_number(deg));
    }
    return csv + csv_line(course);
}

std::vector<DeviationRun> runs_in(const std::string& csv) {
    const auto rows = parse_csv(csv);
    std::vector<DeviationRun> runs;
    for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
        runs.push_back({.angle_deg = parse_csv_number(rows[i].at(0)),
                        .falls_back = static_cast<std::uint32_t>(std::stoul(rows[i].at(1))),
                        .age_ms = parse_csv_number(rows[i].at(2)).value(),
                        .lost = static_cast<std::uint32_t>(std::stoul(rows[i].at(3))),
                        .wait_ms = parse_csv_number(rows[i].at(4)),
                        .course_deg = {}});
    }
    for (const std::string& deg : rows.back()) {
        runs.front().course_deg.push_back(parse_csv_number(deg).value());
    }
    return runs;
}

/// The runs of one kind, beside those without a fault.
struct Tally {
    Tally(const std::vector<DeviationRun>& runs, const std::vector<DeviationRun>& calm) {
        for (std::size_t i = 0; i < runs.size(); ++i) {
            fell_back += runs[i].falls_back > 0 ? 1 : 0;
            ages_ms.push_back(runs[i].age_ms);
            lost.push_back(runs[i].lost);
            if (runs[i].wait_ms) waits_ms.push_back(*runs[i].wait_ms);
            fell += runs[i].angle_deg ? 0 : 1;
            if (runs[i].angle_deg) angles_deg.push_back(*runs[i].angle_deg);
            if (!runs[i].angle_deg || !calm[i].angle_deg) continue;
            ratios.push_back(*runs[i].angle_deg / *calm[i].angle_deg);
            within += ratios.back() <= target ? 1 : 0;
        }
    }

    std::size_t fell = 0;
    std::size_t within = 0;
    std::size_t fell_back = 0;
    std::vector<double> angles_deg, ratios, ages_ms, lost, waits_ms;
};

std::vector<std::string> row_of(const Kind& kind, const Tally& tally) {
    const bool is_calm = kind.fault == BrokerFault::none;
    const std::string of_all = " of " + std::to_string(tally.lost.size());
    return {std::to_string(kind.brokers),
            std::string{name_of(kind.fault)},
            std::to_string(tally.fell) + of_all,
            spread(tally.angles_deg, 1),
            is_calm ? "" : spread(tally.ratios, 2),
            is_calm ? "" : std::to_string(tally.within) + of_all,
            std::to_string(tally.fell_back) + of_all,
            spread(tally.ages_ms, 1),
            spread(tally.lost, 0),
            spread(tally.waits_ms, 0)};
}

PlotSeries course_of(const Kind& kind, const DeviationRun& run) {
    PlotSeries course{.label = std::string{name_of(kind.fault)}, .points = {}, .marked = false};
    for (std::size_t i = 0; i < run.course_deg.size(); ++i) {
        const std::chrono::duration<double> at = static_cast<int>(i) * course_each - course_before;
        course.points.push_back({.x = at.count(), .y = run.course_deg[i]});
    }
    return course;
}

PlotPanel panel_of(std::size_t brokers) {
    return {.title = brokers_text(brokers) + ": one pole, one wind, one shove",
            .x_label = "from the fault on (s)",
            .y_label = "angle (degrees)",
            .series = {},
            .ticks_at_points = false,
            .y_from = -10,
            .y_to = 10,
            .marked_x = 0,
            .marked_label = "fault"};
}

/// One series for each fault, over the numbers of brokers.
PlotPanel panel_of(const std::map<BrokerFault, std::vector<PlotPoint>>& ratios) {
    PlotPanel panel{.title = "Greatest angle, to that without the fault",
                    .x_label = "brokers",
                    .y_label = "ratio",
                    .series = {}};
    for (const auto& [fault, points] : ratios) {
        panel.series.push_back(
            {.label = std::string{name_of(fault)}, .points = points, .line = false});
    }
    return panel;
}

constexpr const char* words =
    R"(The pole at 50 samples a second in gusts (another torque each 0.1 s, up to %w Nm either way) through brokers with the
profile lan and links. %h The deadline is %d ms (F + 2 P + D, F = 50 ms); without a command
the cart's motor stops. At a random moment something befalls the broker of both robots, and at that very moment somebody
shoves the pole, which then turns by %s rad/s. "Greatest angle": in the five seconds from then on; "ratio": to that of the
same pole, wind and shove without the fault. Each three: least, median, greatest of %n poles; a pole that leans 29 degrees
has fallen. A broker alone has no store: when it is started again it knows no session, and the law's robot, which only
listens, hears of that at its next PINGREQ (keep-alive 30 s). With a store it would be as if it had been silent.)";

}  // namespace

std::vector<SeparateRun> runs_of(const DeviationPlan& plan, const LoopGround& ground) {
    std::vector<SeparateRun> runs;
    for (const Kind& kind : kinds_with(plan.brokers)) {
        runs.push_back({file_of(plan, ground.world, kind),
                        [plan, ground, kind] { return outcome(plan, ground, kind); },
                        ground.world == LoopWorld::processes});
    }
    return runs;
}

Section deviation_section(const DeviationPlan& plan, LoopWorld world,
                          const std::filesystem::path& folder) {
    SummaryTable table{
        .head = {"brokers", "what befalls one", "fell", "greatest angle", "ratio", "within 1.1",
                 "fell back", "greatest age", "rounds lost", "without a command"},
        .units = {"", "", "", "degrees", "", "", "", "ms", "", "ms"},
        .rows = {}};
    const std::string name = "deviation_" + std::string{name_of(world)};
    Plot figure{.name = name, .panels = {}};
    std::map<BrokerFault, std::vector<PlotPoint>> ratios;
    std::vector<DeviationRun> calm;
    for (const Kind& kind : kinds_with(plan.brokers)) {
        const auto runs = runs_in(outcome_of(file_of(plan, world, kind), folder));
        if (kind.fault == BrokerFault::none) {
            calm = runs;
            figure.panels.push_back(panel_of(kind.brokers));
        }
        const Tally tally(runs, calm);
        table.rows.push_back(row_of(kind, tally));
        figure.panels.back().series.push_back(course_of(kind, runs.front()));
        if (kind.fault == BrokerFault::none) continue;
        for (const double ratio : tally.ratios) {
            ratios[kind.fault].push_back({.x = static_cast<double>(kind.brokers), .y = ratio});
        }
    }
    figure.panels.push_back(panel_of(ratios));
    std::string text = words;
    text.replace(text.find("%w"), 2, number_text(wind_nm, 2));
    text.replace(text.find("%h"), 2, how_it_is(world));
    text.replace(text.find("%s"), 2, number_text(plan.shove_rad_s, 1));
    text.replace(text.find("%d"), 2, std::to_string(deadline_ms_for(world, period_ms)));
    text.replace(text.find("%n"), 2, std::to_string(plan.runs));
    return {.title = "How far a pole leans when its loop's broker fails" + where_text(world),
            .words = std::move(text),
            .tables = {{name, std::move(table)}},
            .figure = std::move(figure)};
}

}  // namespace romano::experiments
