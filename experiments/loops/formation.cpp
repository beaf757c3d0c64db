#include "experiments/loops/formation.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "experiments/loops/loop_robot.h"
#include "experiments/loops/spread.h"
#include "experiments/sweep/csv.h"
#include "firmware/posix/simple_laws.h"
#include "overlay/sim/seed.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using firmware::Body;
using firmware::Pose;
using firmware::Speed;

constexpr double ahead_of_axle_mm = 50;
constexpr double error_share_s = 2;  // of the error, a second
constexpr double leader_mm_s = 200;
constexpr double most_leader_deg_s = 15;
constexpr Duration bends_each = 8s;  // to the left and to the right
constexpr std::array places{WedgePlace{-300, 300}, WedgePlace{-300, -300}, WedgePlace{-600, 600},
                            WedgePlace{-600, -600}};
constexpr Duration drives_before = 6s;
constexpr Duration looked_at = 5s;
constexpr Duration course_before = 1s;
constexpr Duration course_each = 20ms;

/// A round takes 18.2 ms of a channel of IEEE 802.15.4 (experiments/README.md), and there is one of
/// each of the four followers in a period.
constexpr std::uint16_t period_ms_in(LoopWorld world) {
    return world == LoopWorld::radio ? 100 : 20;
}

struct Vector {
    double x;
    double y;
};

/// Something ahead and to the left of who looks that way, as seen from above.
Vector turned(double ahead, double left, double heading_deg) {
    const double angle = heading_deg * std::numbers::pi / 180;
    return {ahead * std::cos(angle) - left * std::sin(angle),
            ahead * std::sin(angle) + left * std::cos(angle)};
}

double distance(const Pose& a, const Pose& b) {
    return std::hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm);
}

/// Drives as it was told last.
class Rover : public Device {
public:
    explicit Rover(const Pose& start) : body_(start) {}

    virtual void move_on(Instant now) { go_on_until(now); }
    [[nodiscard]] const Pose& pose() const { return body_.pose(); }
    [[nodiscard]] std::uint32_t falls_back() const { return falls_back_; }

    std::size_t sense(Instant now, MutableBytes room) override {
        move_on(now);
        const auto location = body_.location();
        std::ranges::copy(location, room.begin());
        return location.size();
    }
    void carry_out(Instant now, Bytes value) override {
        move_on(now);
        speed_ = firmware::speed_of(value).value_or(Speed{});
    }
    void fall_back(Instant now, control::Fallback) override {
        move_on(now);
        ++falls_back_;
        speed_ = {};
    }

protected:
    void go_on_until(Instant now) {
        if (moved_at_) body_.go_on(speed_, std::chrono::duration<double>(now - *moved_at_).count());
        moved_at_ = now;
    }
    Speed speed_;

private:
    Body body_;
    std::optional<Instant> moved_at_;
    std::uint32_t falls_back_ = 0;
};

/// Drives in bends, and controls the others.
class Leader final : public Rover {
public:
    Leader() : Rover(Pose{}) {}

    void move_on(Instant now) override {
        go_on_until(now);
        if (!set_out_at_) return;
        const std::chrono::duration<double> bend = (now - *set_out_at_) % bends_each;
        const std::chrono::duration<double> whole = bends_each;
        const double phase = 2 * std::numbers::pi * bend / whole;
        speed_ = {leader_mm_s, most_leader_deg_s * std::sin(phase)};
    }
    std::optional<std::size_t> control(Instant now, const RomanoId& plant,
                                       const control::Sample& sample, MutableBytes room) override {
        const auto follower = firmware::pose_of(sample.value);
        const auto place = places_.find(plant);
        if (!follower || place == places_.end()) return std::nullopt;
        move_on(now);
        const auto speed =
            firmware::octets_of(speed_to_place(pose(), speed_, place->second, *follower));
        std::ranges::copy(speed, room.begin());
        return speed.size();
    }
    /// It stands until then.
    void set_out(Instant now) { set_out_at_ = now; }
    void give_place(const RomanoId& follower, const WedgePlace& place) {
        places_.emplace(follower, place);
    }

private:
    std::map<RomanoId, WedgePlace> places_;
    std::optional<Instant> set_out_at_;
};

}  // namespace

Pose place_at(const Pose& leader, const WedgePlace& place) {
    const Vector beside = turned(place.ahead_mm, place.left_mm, leader.heading_deg);
    return {leader.x_mm + beside.x, leader.y_mm + beside.y, leader.heading_deg};
}

Speed speed_to_place(const Pose& leader, const Speed& speed, const WedgePlace& place,
                     const Pose& follower) {
    const double turn = speed.deg_s * std::numbers::pi / 180;
    // How the point of the leader's plane that far ahead and to the left moves, as the leader sees
    // it.
    const auto moves_at = [&](const WedgePlace& at) {
        return Vector{speed.mm_s - turn * at.left_mm, turn * at.ahead_mm};
    };
    // A cart looks where its axle moves to: so the point ahead of it is there.
    const Vector moves = moves_at(place);
    const double size = std::hypot(moves.x, moves.y);
    const Vector looks = size > 0 ? Vector{moves.x / size, moves.y / size} : Vector{1, 0};
    const WedgePlace ahead{place.ahead_mm + ahead_of_axle_mm * looks.x,
                           place.left_mm + ahead_of_axle_mm * looks.y};
    const Pose wanted = place_at(leader, ahead);
    const Pose is = place_at(follower, {ahead_of_axle_mm, 0});
    const Vector seen_by_leader = moves_at(ahead);
    const Vector wanted_moves = turned(seen_by_leader.x, seen_by_leader.y, leader.heading_deg);
    const Vector drive{wanted_moves.x + error_share_s * (wanted.x_mm - is.x_mm),
                       wanted_moves.y + error_share_s * (wanted.y_mm - is.y_mm)};
    const Vector seen = turned(drive.x, drive.y, -follower.heading_deg);
    return {seen.x, seen.y / ahead_of_axle_mm * 180 / std::numbers::pi};
}

FormationRun formation(const LoopGround& ground, std::size_t brokers, BrokerFault fault,
                       std::uint64_t seed) {
    const auto around = make_brokers(ground, brokers, seed);
    const BrokerAddress first = around->address_of(0);
    Leader leader;
    LoopRobot leads(around->surroundings(), seed, 1, first, leader);
    std::vector<std::unique_ptr<Rover>> rovers;
    std::vector<std::unique_ptr<LoopRobot>> followers;
    for (const WedgePlace& place : places) {
        const auto number = static_cast<std::uint32_t>(2 + followers.size());
        rovers.push_back(std::make_unique<Rover>(place_at({}, place)));
        followers.push_back(std::make_unique<LoopRobot>(around->surroundings(), seed, number, first,
                                                        *rovers.back()));
        leader.give_place(followers.back()->id(), place);
        followers.back()->start();
    }
    leads.start();
    const std::uint16_t period_ms = period_ms_in(ground.world);
    for (const auto& follower : followers) {
        leads.open(follower->id(), leads.id(),
                   {.period_ms = period_ms,
                    .deadline_ms = deadline_ms_for(ground.world, period_ms),
                    .fallback = control::Fallback::stop});
    }
    const auto are_led = [&] {
        return std::ranges::all_of(followers, [](const auto& one) { return one->is_controlled(); });
    };
    if (!around->run_until(are_led, 60s)) {
        throw std::runtime_error("the formation's loops did not begin within a minute");
    }
    leader.set_out(around->now());
    Random random(sim::seed_of(seed, "strike"));
    around->run_for(drives_before + random.between(0s, bends_each));

    FormationRun run;
    const auto error_mm = [&] {
        double greatest = 0;
        leader.move_on(around->now());
        for (std::size_t i = 0; i < places.size(); ++i) {
            rovers[i]->move_on(around->now());
            greatest =
                std::max(greatest, distance(rovers[i]->pose(), place_at(leader.pose(), places[i])));
        }
        return greatest;
    };
    const auto falls_back = [&] {
        std::uint32_t all = 0;
        for (const auto& rover : rovers) all += rover->falls_back();
        return all;
    };
    const auto follow = [&](Duration time) {
        double greatest = 0;
        for (const Instant end = around->now() + time; around->now() < end;) {
            around->run_for(course_each);
            run.course_mm.push_back(error_mm());
            greatest = std::max(greatest, run.course_mm.back());
        }
        return greatest;
    };
    follow(course_before);
    const std::uint32_t before = falls_back();
    around->strike(fault);
    if (fault == BrokerFault::roaming) {
        leads.roam_to(around->address_of(1));
        for (const auto& follower : followers) follower->roam_to(around->address_of(1));
    }
    run.error_mm = follow(looked_at);
    run.falls_back = falls_back() - before;
    return run;
}

namespace {

std::string file_of(const FormationPlan& plan, LoopWorld world, const Kind& kind) {
    return "formation_" + std::string{name_of(world)} + "_brokers" + std::to_string(kind.brokers) +
           "_fault" + std::to_string(static_cast<int>(kind.fault)) + "_runs" +
           std::to_string(plan.runs) + "_seed" + std::to_string(plan.seed);
}

/// The course of the first one alone.
std::string outcome(const FormationPlan& plan, const LoopGround& ground, const Kind& kind) {
    std::string csv;
    CsvRow course;
    for (std::size_t i = 0; i < plan.runs; ++i) {
        const FormationRun run =
            formation(ground, kind.brokers, kind.fault, sim::seed_of(plan.seed, "formation", i));
        csv += csv_line({csv_number(run.error_mm), std::to_string(run.falls_back)});
        if (i > 0) continue;
        for (const double mm : run.course_mm) course.push_back(csv_number(mm));
    }
    return csv + csv_line(course);
}

PlotPanel panel_of(std::size_t brokers) {
    return {.title = brokers_text(brokers) + ": distance from the place",
            .x_label = "from the fault on (s)",
            .y_label = "greatest of four robots (mm)",
            .series = {},
            .ticks_at_points = false,
            .y_from = 0,
            .marked_x = 0,
            .marked_label = "fault"};
}

constexpr const char* words =
    R"(Robot 1 drives at %v mm/s in bends of up to %b degrees/s and controls four others, each of which has a place in a wedge
behind it, at %p samples a second; deadline %d ms, and a robot without a command stops. Brokers, network and faults as for
the pole. "Error": the distance of a follower from its place, the greatest of the four; in the table the greatest in the
five seconds from the fault on, least, median and greatest of %n runs.)";

}  // namespace

std::vector<SeparateRun> runs_of(const FormationPlan& plan, const LoopGround& ground) {
    std::vector<SeparateRun> runs;
    for (const Kind& kind : kinds_with(plan.brokers)) {
        runs.push_back({file_of(plan, ground.world, kind),
                        [plan, ground, kind] { return outcome(plan, ground, kind); },
                        ground.world == LoopWorld::processes});
    }
    return runs;
}

Section formation_section(const FormationPlan& plan, LoopWorld world,
                          const std::filesystem::path& folder) {
    SummaryTable table{.head = {"brokers", "what befalls one", "runs", "error", "fell back"},
                       .units = {"", "", "", "mm", "times"},
                       .rows = {}};
    const std::string name = "formation_" + std::string{name_of(world)};
    Plot figure{.name = name, .panels = {}};
    for (const Kind& kind : kinds_with(plan.brokers)) {
        const auto rows = parse_csv(outcome_of(file_of(plan, world, kind), folder));
        std::vector<double> errors;
        std::vector<double> falls_back;
        for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
            errors.push_back(parse_csv_number(rows[i].at(0)).value());
            falls_back.push_back(parse_csv_number(rows[i].at(1)).value());
        }
        table.rows.push_back({std::to_string(kind.brokers), std::string{name_of(kind.fault)},
                              std::to_string(errors.size()), spread(std::move(errors), 1),
                              spread(std::move(falls_back), 0)});
        PlotSeries course{.label = std::string{name_of(kind.fault)}, .points = {}, .marked = false};
        for (std::size_t i = 0; i < rows.back().size(); ++i) {
            const std::chrono::duration<double> at =
                static_cast<int>(i + 1) * course_each - course_before;
            course.points.push_back(
                {.x = at.count(), .y = parse_csv_number(rows.back()[i]).value()});
        }
        if (kind.fault == BrokerFault::none) figure.panels.push_back(panel_of(kind.brokers));
        figure.panels.back().series.push_back(std::move(course));
    }
    std::string text = words;
    text.replace(text.find("%v"), 2, number_text(leader_mm_s, 0));
    text.replace(text.find("%b"), 2, number_text(most_leader_deg_s, 0));
    text.replace(text.find("%p"), 2, std::to_string(1'000 / period_ms_in(world)));
    text.replace(text.find("%d"), 2, std::to_string(deadline_ms_for(world, period_ms_in(world))));
    text.replace(text.find("%n"), 2, std::to_string(plan.runs));
    return {.title = "A formation of five robots when their broker fails" + where_text(world),
            .words = std::move(text),
            .tables = {{name, std::move(table)}},
            .figure = std::move(figure)};
}

}  // namespace romano::experiments
