#include <optional>
#include <string>

#include "experiments/paper/backbone.h"
#include "experiments/sweep/csv.h"
#include "overlay/sim/seed.h"

namespace romano::experiments {
namespace {

constexpr double hundred = 100;
constexpr double good_delivery = 0.995;
constexpr double half = 0.5;

std::string name_of(const BackbonePlan& plan, const Beacons& beacons, std::size_t brokers) {
    return "backbone_" + beacons.profile + std::to_string(beacons.every.count()) + "_brokers" +
           std::to_string(brokers) + "_seed" + std::to_string(plan.seed);
}

std::string to_csv(const BackboneRun& run) {
    return csv_line({csv_number(run.beacon_octets), csv_number(run.beacons_air),
                     csv_number(run.beacons_heard), csv_number(run.delivered_at_100),
                     csv_number(run.carried_per_s)});
}

BackboneRun run_from(const std::string& csv) {
    const CsvRow row = parse_csv(csv).at(0);
    const auto at = [&](std::size_t column) { return parse_csv_number(row.at(column)).value(); };
    return {.beacon_octets = at(0),
            .beacons_air = at(1),
            .beacons_heard = at(2),
            .delivered_at_100 = at(3),
            .carried_per_s = at(4)};
}

constexpr const char* words =
    R"(All brokers and one cell of five robots are on one channel, 5 m from each other. Each broker broadcasts its
beacons there, as large as the shipped cluster makes them with two robots at each broker, with the headers
of RTPS; 6LoWPAN cuts what is longer than a frame. Nothing else of the cluster is sent, and a beacon that
is lost changes nothing: it is the least that the overlay takes. "Beacons' air" is the sum of all brokers'
airtime: beyond 100 % they are on the air at once and destroy each other.)";

/// From which number on something is so, and stays so.
std::string from_text(const std::optional<std::size_t>& brokers, std::size_t most) {
    return brokers ? std::to_string(*brokers) : "more than " + std::to_string(most);
}

}  // namespace

std::vector<SeparateRun> runs_of(const BackbonePlan& plan) {
    std::vector<SeparateRun> runs;
    for (const Beacons& beacons : plan.beacons) {
        for (const std::size_t brokers : plan.brokers) {
            const std::uint64_t seed = sim::seed_of(plan.seed, "backbone", brokers);
            runs.push_back({name_of(plan, beacons, brokers), [beacons, brokers, seed] {
                                return to_csv(backbone_run(brokers, beacons, seed));
                            }});
        }
    }
    return runs;
}

Section backbone_section(const BackbonePlan& plan, const std::filesystem::path& folder) {
    SummaryTable table{.head = {"profile", "brokers", "beacon", "beacons' air", "beacons heard",
                                "delivered at 100/s", "carries"},
                       .units = {"", "", "octets", "%", "%", "%", "1/s"},
                       .rows = {}};
    SummaryTable limits{
        .head = {"profile", "delivery below 99.5 % from brokers", "carries less than half from"},
        .units = {},
        .rows = {}};
    PlotPanel air{.title = "Beacons on the air",
                  .x_label = "brokers",
                  .y_label = "of the time (%)",
                  .series = {},
                  .y_from = 0};
    PlotPanel carries{.title = "What is left for a cell",
                      .x_label = "brokers",
                      .y_label = "messages/s",
                      .series = {},
                      .y_from = 0};
    for (const Beacons& beacons : plan.beacons) {
        PlotSeries of_air{.label = beacons.profile, .points = {}};
        PlotSeries carried{.label = beacons.profile, .points = {}};
        std::optional<double> alone;
        std::optional<std::size_t> bad_from;
        std::optional<std::size_t> half_from;
        for (const std::size_t brokers : plan.brokers) {
            const BackboneRun run = run_from(outcome_of(name_of(plan, beacons, brokers), folder));
            if (!alone) alone = run.carried_per_s;
            if (run.delivered_at_100 >= good_delivery) {
                bad_from.reset();
            } else if (!bad_from) {
                bad_from = brokers;
            }
            if (run.carried_per_s >= half * *alone) {
                half_from.reset();
            } else if (!half_from) {
                half_from = brokers;
            }
            table.rows.push_back({beacons.profile, std::to_string(brokers),
                                  number_text(run.beacon_octets, 0),
                                  number_text(hundred * run.beacons_air, 1),
                                  number_text(hundred * run.beacons_heard, 1),
                                  number_text(hundred * run.delivered_at_100, 1),
                                  number_text(run.carried_per_s, 1)});
            const auto x = static_cast<double>(brokers);
            of_air.points.push_back({.x = x, .y = hundred * run.beacons_air});
            carried.points.push_back({.x = x, .y = run.carried_per_s});
        }
        const std::size_t most = plan.brokers.empty() ? 0 : plan.brokers.back();
        limits.rows.push_back(
            {beacons.profile, from_text(bad_from, most), from_text(half_from, most)});
        air.series.push_back(std::move(of_air));
        carries.series.push_back(std::move(carried));
    }
    return {.title = "Beyond the paper: beacons on the robots' own channel",
            .words = words,
            .tables = {{"backbone_limits", std::move(limits)}, {"backbone", std::move(table)}},
            .figure = {.name = "backbone", .panels = {std::move(air), std::move(carries)}}};
}

}  // namespace romano::experiments
