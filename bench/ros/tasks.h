// The work that all contestants do, and what is measured of it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bench/ros/contestant.h"
#include "bench/ros/figures.h"

namespace romano::bench::ros {

struct Plan {
    bool quick = false;
    std::vector<std::string> parts;  // names of all_parts()
    std::vector<Contestant> contestants;
    std::filesystem::path programs;
    std::filesystem::path scratch;
};

[[nodiscard]] const std::vector<std::string>& all_parts();

/// One piece of work for one contestant.
struct Task {
    std::string name;  // "delay_100_32", "fan_out_50"
    std::string part;
    bool also_best_effort = false;
    bool needs_infrastructure = false;  // it is about its death
    bool all_at_once = false;           // takes no CPU: contestants do it at the same time
    std::function<Figures(const Contestant&, const Plan&)> work;
};

/// Of the plan's parts.
[[nodiscard]] std::vector<Task> tasks_of(const Plan& plan);
[[nodiscard]] bool takes_part(const Contestant& contestant, const Task& task);

// What the report draws over: messages a second, subscribers, and robots with telemetry.
[[nodiscard]] std::vector<int> rates_of(const Plan& plan, int octets);
[[nodiscard]] std::vector<int> fan_outs_of(const Plan& plan);
[[nodiscard]] int robots_of(const Plan& plan);

}  // namespace romano::bench::ros
