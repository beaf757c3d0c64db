// A field with simulated robots on it: they run here, on real sockets at real brokers, and their
// trails are written down. What the applications of the ROMANO paper are shown with.
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "experiments/operator/node_watch.h"
#include "experiments/report/plot.h"
#include "firmware/posix/simulated_robot.h"

namespace romano::experiments {

class Field {
public:
    /// Throws std::runtime_error when the broker cannot be found.
    Field(const std::string& host, std::uint16_t port);

    struct Placing {
        std::string id;
        firmware::Pose start{};
        std::string telemetry{};  // tells its location on this topic, 20 times a second
        std::string follow{};     // copies the path that is told on this topic
        decltype(firmware::SimulatedRobotOptions::hears) hears{};
    };
    void add(const Placing& placing);

    /// Throws std::runtime_error when they are not established in time.
    void wait_until_established();
    /// What the operator sends, at QoS 1. Throws when the broker does not answer.
    void send(const std::string& topic, const std::vector<std::uint8_t>& message);
    /// Until `done`, or throws with `what` after ten seconds.
    void wait_for(const std::function<bool()>& done, const std::string& what);
    void run_for(std::chrono::milliseconds time);

    [[nodiscard]] boost::asio::io_context& io() { return io_; }
    [[nodiscard]] firmware::SimulatedRobot& robot(std::size_t robot) { return *robots_[robot]; }
    [[nodiscard]] const firmware::Pose& pose(std::size_t robot) const {
        return robots_[robot]->body().pose();
    }
    [[nodiscard]] std::uint64_t commands(std::size_t robot) const {
        return robots_[robot]->counters().commands;
    }
    /// Where a robot was so far, from its start.
    [[nodiscard]] const std::vector<firmware::Pose>& places(std::size_t robot) const {
        return trails_[robot];
    }
    /// A robot's way so far, a point every few millimetres.
    [[nodiscard]] PlotSeries trail(std::size_t robot) const;
    /// One line a place: robot, x_mm, y_mm, heading_deg.
    void write_csv(const std::filesystem::path& file) const;

private:
    void turn();
    void write_down();
    [[nodiscard]] std::string no_answer() const;

    boost::asio::io_context io_{1};
    BrokerAddress broker_;
    NodeWatch operator_;
    std::vector<Placing> placings_;
    std::vector<std::unique_ptr<firmware::SimulatedRobot>> robots_;
    std::vector<std::vector<firmware::Pose>> trails_;
};

}  // namespace romano::experiments
