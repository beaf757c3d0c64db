#include "experiments/applications/field.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "broker/net/asio_endpoint.h"
#include "broker/net/clock.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr double point_every_mm = 10;

bool is_elsewhere(const firmware::Pose& a, const firmware::Pose& b) {
    return a.x_mm != b.x_mm || a.y_mm != b.y_mm || a.heading_deg != b.heading_deg;
}

}  // namespace

Field::Field(const std::string& host, std::uint16_t port)
    : broker_(resolve_broker(io_, host, port)),
      operator_(io_, broker_, "romano-field", {.t_retry = 1s}) {}

void Field::add(const Placing& placing) {
    firmware::SimulatedRobotOptions options;
    options.robot.node.id = message::RomanoId::parse(placing.id).value();
    options.robot.broker = net::to_endpoint(broker_);
    options.robot.timing.t_retry = 1s;
    options.robot.seed = robots_.size();
    options.telemetry_topic = placing.telemetry;
    options.telemetry_every = 50ms;
    options.follow = placing.follow;
    options.start = placing.start;
    options.hears = placing.hears;
    placings_.push_back(placing);
    robots_.push_back(std::make_unique<firmware::SimulatedRobot>(
        io_, options, [](const auto&, const std::string&) {}));
    trails_.push_back({placing.start});
}

void Field::wait_until_established() {
    wait_for(
        [this] {
            return std::ranges::all_of(
                robots_, [](const auto& robot) { return robot->counters().established > 0; });
        },
        "the robots were not established: is there a broker with a ROMANO server?");
}

void Field::send(const std::string& topic, const std::vector<std::uint8_t>& message) {
    operator_.publish(topic, message, mqttsn::Qos::at_least_once);
    wait_for([this] { return operator_.is_idle(); }, no_answer());
}

void Field::wait_for(const std::function<bool()>& done, const std::string& what) {
    const Instant end = net::now() + 10s;
    while (!done()) {
        if (net::now() >= end) throw std::runtime_error(what);
        turn();
    }
}

void Field::run_for(std::chrono::milliseconds time) {
    for (const Instant end = net::now() + time; net::now() < end;) turn();
}

void Field::turn() {
    io_.run_one_for(5ms);
    if (operator_.has_failed()) throw std::runtime_error(no_answer());
    write_down();
}

std::string Field::no_answer() const {
    if (operator_.denial() == mqttsn::ReturnCode::congestion) {
        return "the broker at " + broker_.address().to_string() + " port " +
               std::to_string(broker_.port()) + " is full or overloaded (congestion)";
    }
    return "no broker answers at " + broker_.address().to_string() + " port " +
           std::to_string(broker_.port()) + " (see -h and -p)";
}

void Field::write_down() {
    for (std::size_t i = 0; i < robots_.size(); ++i) {
        if (is_elsewhere(trails_[i].back(), pose(i))) trails_[i].push_back(pose(i));
    }
}

PlotSeries Field::trail(std::size_t robot) const {
    PlotSeries series{.label = placings_[robot].id, .points = {}, .line = false, .small = true};
    const auto& trail = trails_[robot];
    for (std::size_t i = 1; i < trail.size(); ++i) {
        const double dx = trail[i].x_mm - trail[i - 1].x_mm;
        const double dy = trail[i].y_mm - trail[i - 1].y_mm;
        const int steps = std::max(1, static_cast<int>(std::hypot(dx, dy) / point_every_mm));
        for (int step = 0; step < steps; ++step) {
            const double part = static_cast<double>(step) / steps;
            series.points.push_back(
                {.x = trail[i - 1].x_mm + part * dx, .y = trail[i - 1].y_mm + part * dy});
        }
    }
    series.points.push_back({.x = trail.back().x_mm, .y = trail.back().y_mm});
    return series;
}

void Field::write_csv(const std::filesystem::path& file) const {
    std::ofstream out(file);
    out << "robot,x_mm,y_mm,heading_deg\n";
    for (std::size_t i = 0; i < trails_.size(); ++i) {
        for (const firmware::Pose& pose : trails_[i]) {
            out << placings_[i].id << ',' << pose.x_mm << ',' << pose.y_mm << ','
                << pose.heading_deg << '\n';
        }
    }
    if (!out) throw std::runtime_error("cannot write `" + file.string() + "`");
}

}  // namespace romano::experiments
