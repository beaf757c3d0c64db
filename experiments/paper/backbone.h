// Beyond the paper: what the brokers' beacons cost when their backbone is the robots' own channel.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "experiments/process/separate_runs.h"
#include "experiments/report/section.h"

namespace romano::experiments {

struct Beacons {
    std::string profile;
    std::chrono::milliseconds every;
};

struct BackbonePlan {
    std::vector<std::size_t> brokers{1, 2, 3, 4, 6, 8, 12, 16, 24, 32};
    std::vector<Beacons> beacons{{"wifi", std::chrono::milliseconds{50}},
                                 {"mesh", std::chrono::milliseconds{1'000}}};
    std::uint64_t seed = 1;
};

struct BackboneRun {
    double beacon_octets = 0;     // a UDP datagram's, as DDS sends it
    double beacons_air = 0;       // share of the time
    double beacons_heard = 0;     // share of those that were due, over all pairs
    double delivered_at_100 = 0;  // share of 100 messages a second to the robots of a cell
    double carried_per_s = 0;     // of 300 a second
};
[[nodiscard]] BackboneRun backbone_run(std::size_t brokers, const Beacons& beacons,
                                       std::uint64_t seed);

[[nodiscard]] std::vector<SeparateRun> runs_of(const BackbonePlan& plan);
/// When all runs are done.
[[nodiscard]] Section backbone_section(const BackbonePlan& plan,
                                       const std::filesystem::path& folder);

}  // namespace romano::experiments
