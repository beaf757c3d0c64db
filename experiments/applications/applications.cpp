#include "experiments/applications/applications.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "experiments/applications/field.h"
#include "experiments/applications/path_error.h"
#include "experiments/operator/robot_message.h"

namespace romano::experiments {
namespace {

Octets move(const char* movement, const std::string& amount) {
    return move_message(Form::binary, movement, amount, 0);
}

void write_picture(const Field& field, std::size_t robots, const std::string& name,
                   const std::string& title, const std::filesystem::path& folder) {
    PlotPanel panel{.title = title,
                    .x_label = "x (mm)",
                    .y_label = "y (mm)",
                    .series = {},
                    .ticks_at_points = false,
                    .is_map = true};
    for (std::size_t i = 0; i < robots; ++i) panel.series.push_back(field.trail(i));
    std::filesystem::create_directories(folder);
    field.write_csv(folder / (name + ".csv"));
    const auto svg = draw({.name = name, .panels = {panel}}, folder);
    if (svg) std::ofstream(folder / (name + ".svg")) << *svg << '\n';
}

/// How far from there it is, in mm. Throws when that is too far.
double expect_at(const Field& field, std::size_t robot, double x_mm, double y_mm) {
    const firmware::Pose& pose = field.pose(robot);
    const double error = std::hypot(pose.x_mm - x_mm, pose.y_mm - y_mm);
    if (error <= 2) return error;
    throw std::runtime_error("robot " + std::to_string(robot) + " is at " +
                             std::to_string(pose.x_mm) + ", " + std::to_string(pose.y_mm) +
                             " mm instead of " + std::to_string(x_mm) + ", " +
                             std::to_string(y_mm));
}

}  // namespace

void run_group_control(const ApplicationOptions& options) {
    constexpr std::size_t robots = 6;
    Field field(options.host, options.port);
    for (std::size_t i = 0; i < robots; ++i) {
        field.add({.id = "0000a00" + std::to_string(i),
                   .start = {.x_mm = 700.0 * static_cast<double>(i), .heading_deg = 90}});
    }
    field.wait_until_established();
    std::uint64_t sent[robots] = {};
    for (std::size_t i = 0; i < robots; ++i) {
        field.send("0000a00" + std::to_string(i),
                   subscribe_message(Form::binary, i % 2 == 0 ? "team/even" : "team/odd"));
    }
    field.run_for(std::chrono::milliseconds{300});  // they subscribe
    const auto command = [&](const std::string& topic, const Octets& message,
                             const auto& is_meant) {
        field.send(topic, message);
        for (std::size_t i = 0; i < robots; ++i) sent[i] += is_meant(i) ? 1U : 0U;
        field.wait_for(
            [&] {
                for (std::size_t i = 0; i < robots; ++i) {
                    if (field.commands(i) < sent[i]) return false;
                }
                return true;
            },
            "a command did not arrive");
    };
    const auto even = [](std::size_t i) { return i % 2 == 0; };
    const auto odd = [](std::size_t i) { return i % 2 == 1; };
    const auto all = [](std::size_t) { return true; };
    for (int side = 0; side < 4; ++side) {  // a square
        command("team/even", move("front", "40cm"), even);
        command("team/even", move("rotate-right", "90deg"), even);
    }
    for (int side = 0; side < 3; ++side) {  // a triangle
        command("team/odd", move("front", "50cm"), odd);
        command("team/odd", move("rotate-right", "120deg"), odd);
    }
    command("0000a005", move("left", "100mm"), [](std::size_t i) { return i == 5; });
    command("common", move("back", "20cm"), all);
    write_picture(field, robots, "group_control",
                  "Movement messages to two teams, to one robot, to all", options.output);
    std::uint64_t commands = 0;
    double error = 0;
    for (std::size_t i = 0; i < robots; ++i) {
        commands += field.commands(i);
        const double x = 700.0 * static_cast<double>(i) - (i == 5 ? 100 : 0);
        error = std::max(error, expect_at(field, i, x, -200));
    }
    std::printf(
        "%zu robots carried out %llu commands and stand within %.1f mm of where they "
        "should\n",
        robots, static_cast<unsigned long long>(commands), error);
}

void run_path_copy(const ApplicationOptions& options) {
    Field field(options.host, options.port);
    field.add({.id = "0000b000", .start = {}, .telemetry = "line"});
    field.add({.id = "0000b001", .start = {.x_mm = 1800}, .follow = "line"});
    field.add({.id = "0000b002", .start = {.x_mm = 1800, .heading_deg = 180}, .follow = "line"});
    field.wait_until_established();
    field.run_for(std::chrono::milliseconds{500});  // the followers learn where it begins
    std::uint64_t sent = 0;
    for (int step = 0; step < 120; ++step) {  // an eight: a left circle, a right circle
        field.send("0000b000", move("front", "30mm"));
        field.send("0000b000", move(step < 60 ? "rotate-left" : "rotate-right", "6deg"));
        sent += 2;
        field.wait_for([&] { return field.commands(0) >= sent; }, "a command did not arrive");
        field.run_for(std::chrono::milliseconds{30});
    }
    const auto& leader = field.pose(0);
    field.wait_for(
        [&] {
            return std::hypot(field.pose(1).x_mm - 1800 - leader.x_mm,
                              field.pose(1).y_mm - leader.y_mm) < 2;
        },
        "the followers did not come to the end of the path");
    field.run_for(std::chrono::milliseconds{200});
    write_picture(field, 3, "path_copy",
                  "One robot drives and tells where it is; two copy its path", options.output);
    expect_at(field, 1, 1800 + leader.x_mm, leader.y_mm);
    expect_at(field, 2, 1800 - leader.x_mm, -leader.y_mm);
    for (const std::size_t copy : {1U, 2U}) {
        const PathError error = path_error(field.places(0), field.places(copy));
        std::printf(
            "robot %zu copied a path of %.0f mm: path error %.1f mm on the mean, %.1f mm "
            "at most\n",
            copy, length_mm(field.places(0)), error.mean_mm, error.most_mm);
        if (error.most_mm > 30) throw std::runtime_error("a copy left the path");
    }
}

}  // namespace romano::experiments
