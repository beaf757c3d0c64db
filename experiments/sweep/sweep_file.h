// What a sweep file says: axes to vary, and the settings that all of its cells share. TOML; the
// keys and their defaults are explained in experiments/README.md.
//
// Reading is strict: an unknown key, a wrong type or an impossible value is a SweepError, one
// sentence that names the setting, the value and what is allowed. Nothing has started by then.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/sweep/cell.h"
#include "experiments/sweep/setting_error.h"

namespace romano::experiments {

using SweepError = SettingError;

/// Who publishes what to whom.
enum class Pattern : std::uint8_t {
    swarm,     // each robot: its messages go in turn to one other robot and to its group
    common,    // the paper's delay experiment: one server publishes to `common`, all robots listen
    commands,  // the paper's delivery experiment: one server publishes to each robot in turn
};
[[nodiscard]] std::string_view name_of(Pattern pattern);

/// What the cells run in.
enum class World : std::uint8_t {
    processes,  // romano-broker as processes, robots on sockets, on this machine
    simulated,  // the same cores in virtual time, on links with delay and loss
    radio,      // so, with the robots on modelled IEEE 802.15.4 cells
    air,        // real brokers and robots, with those cells between them in real time
};
[[nodiscard]] constexpr bool is_in_virtual_time(World world) {
    return world == World::simulated || world == World::radio;
}
[[nodiscard]] constexpr bool is_on_radio(World world) {
    return world == World::radio || world == World::air;
}
[[nodiscard]] std::string_view name_of(World world);

/// One of a simulated world's networks.
struct SimulatedLink {
    double delay_min_ms = 0.05;
    double delay_max_ms = 0.3;
    double loss_percent = 0;

    friend bool operator==(const SimulatedLink&, const SimulatedLink&) = default;
};

/// The robots' network of a radio world.
struct SweptRadio {
    std::uint32_t channels = 16;    // which the brokers' cells take in turn
    double router_distance_m = 30;  // from one to the next, in a square grid

    friend bool operator==(const SweptRadio&, const SweptRadio&) = default;
};

struct SweepSettings {
    std::string name;
    World world = World::processes;
    SimulatedLink client_link;  // between robots and brokers
    SimulatedLink wire;         // between brokers, as the backbone of that name
    SimulatedLink wifi{.delay_min_ms = 1, .delay_max_ms = 5, .loss_percent = 1};  // as well
    SweptRadio radio;
    Pattern pattern = Pattern::swarm;
    std::uint32_t repetitions = 1;
    std::chrono::duration<double> duration{10};         // of the load
    std::chrono::duration<double> fault_after{4};       // from the start of the load
    std::chrono::duration<double> pause{2};             // from one step of a fault to the next
    std::chrono::duration<double> drain{15};            // at most, for the last deliveries
    std::chrono::duration<double> start_within{60};     // for all brokers to be in one view
    std::chrono::duration<double> retry{1};             // the robots' Tretry
    std::chrono::duration<double> publish_within{0.5};  // of its time: else the run failed
    double probe_per_s = 0;  // messages of the failover probe at each broker; 0: there is none
    std::vector<std::string> broker_options;  // what the brokers are told besides
    std::uint32_t group = 5;                  // robots that share a group topic
    std::uint32_t domain_base = 40;           // first DDS domain id
    std::string network;                      // empty: one that is free
    std::uint16_t port = 11883;
    std::filesystem::path output;

    friend bool operator==(const SweepSettings&, const SweepSettings&) = default;
};

/// Cells take their DDS domain ids from this many, in turn.
inline constexpr std::uint32_t domains_in_turn = 40;

struct Sweep {
    SweepSettings settings;
    std::vector<Cell> cells;  // in order of their numbers: repetitions outermost
    std::string text;         // the file, as read
};

/// The rows of one are rows of the other: both mean the same cells and settings, whatever words,
/// comments and order say so. What they are called and where they run does not matter.
[[nodiscard]] bool is_same_experiment(const Sweep& a, const Sweep& b);

[[nodiscard]] Sweep parse_sweep(std::string_view text, const std::string& file_name);
[[nodiscard]] Sweep read_sweep(const std::filesystem::path& file);

}  // namespace romano::experiments
