// One run of an experiment of the ROMANO paper, on a radio cell in virtual time: a broker on a
// wire, a border router, robots two metres around it, all with the shipped cores.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace romano::experiments {

inline constexpr std::size_t papers_robots = 5;
inline constexpr std::size_t papers_messages = 5'000;  // of a run

struct PaperCell {
    std::uint32_t router_baud = 115'200;
    unsigned channel = 26;
    std::size_t robots = papers_robots;
    std::uint64_t seed = 1;
};

/// "The ROMANO server script publishes messages to the connected robots", one after the other.
struct DeliveryRun {
    std::size_t sent = 0;
    std::size_t delivered = 0;
    /// What was accepted before the first overflow, and came: a border router that stops there.
    std::size_t delivered_if_it_stops = 0;
    std::size_t given_up_on_air = 0;  // frames, after the last repetition
    double lasted_s = 0;              // with the rest that waited
    double router_air_s = 0;          // what the radios sent
    double robots_air_s = 0;
    std::optional<std::size_t> overflow_after = std::nullopt;  // messages; empty: there was none
    std::optional<double> carried_per_s = std::nullopt;  // from the overflow to the last message
};
[[nodiscard]] DeliveryRun delivery_run(const PaperCell& cell, double rate, std::size_t messages);

/// One robot's, in ms.
struct RobotDelay {
    double least = 0;
    double mean = 0;
    double most = 0;
};
/// "The server published message at a rate of 20 MPS to the topic common": the quickest robot
/// first. A robot that heard nothing has no delay.
[[nodiscard]] std::vector<RobotDelay> delay_run(const PaperCell& cell, std::size_t messages);

}  // namespace romano::experiments
