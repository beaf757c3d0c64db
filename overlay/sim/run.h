// Runs of the simulator by seed: one seed is one cluster, its robots, their traffic and its faults.
//
// First faults happen while robots publish: nothing may break (safety). Then faults end, and within
// a bounded time everything must work again and be complete (liveness).
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "overlay/sim/invariants.h"
#include "overlay/sim/promises.h"
#include "overlay/sim/random_faults.h"
#include "overlay/sim/trace.h"

namespace romano::sim {

/// What the seed does not decide. Empty or 0: it does.
///
/// Profile, elector, detector and machine are the seed's only when it shall search what ships; else
/// they are those of the first searches (silence of 100 ms means death, component, fixed), so that
/// a seed that was bad then is the same run today.
struct RunOptions {
    bool as_shipped = false;
    /// Robots and brokers seal their packets, and a stranger plays back what it recorded.
    bool is_protected = false;
    /// They speak DTLS, every second robot with a Connection ID, and the stranger bends what it
    /// recorded.
    bool speaks_dtls = false;
    /// Robots, which have keys, may not say and read everything; in the middle of the faults their
    /// rights change.
    bool has_rights = false;
    /// Brokers send once for many; three robots of four listen, and all have one topic more.
    bool has_cells = false;
    /// Half of the machines cannot take addresses of others.
    bool are_some_unable = false;
    /// Time daemons slew the brokers' clocks by up to a twelfth.
    bool are_clocks_slewed = false;
    std::string profile{};
    std::size_t brokers = 0;
    std::size_t robots = 0;
    std::string elector{};
    std::string detector{};
    std::optional<std::uint32_t> acks{};
    std::vector<Fault> faults{};
    Duration faults_last{
        std::chrono::seconds{10}};  // whole milliseconds; as ClusterWorld::in_scale
    Duration settles_within{std::chrono::seconds{30}};  // no sooner with a quick profile
    Trace::Listener trace{};                            // lines of what happens; slow
};

struct RunResult {
    std::uint64_t seed = 0;
    std::uint64_t trace_hash = 0;
    std::string setting;  // "3 brokers, 5 robots, component, acks 1"
    std::string profile;  // empty: the times of the first searches
    std::string detector;
    std::string elector;
    std::uint64_t acknowledged = 0;
    std::uint64_t received = 0;
    std::uint64_t sent_to_cells = 0;  // datagrams, each for several listeners
    std::uint64_t sealed = 0;         // packets of protected worlds, records of those with DTLS
    std::uint64_t moved = 0;          // robots with a Connection ID, to other addresses
    FaultCounts faults{};             // how often each kind happened
    Duration virtual_time{0};
    Violations violations;
    Breaches breaches;  // of invariants; no failure by themselves

    [[nodiscard]] bool is_good() const { return violations.empty(); }
};

[[nodiscard]] RunResult run_seed(std::uint64_t seed, const RunOptions& options);

struct SeedRange {
    std::uint64_t first = 1;
    std::uint64_t last = 1;  // inclusive
};
/// Runs them one after the other, telling each result. False: some promise was broken. When a core
/// aborts, the seed and the command that replays it are printed first.
bool run_seeds(const SeedRange& seeds, const RunOptions& options,
               const std::function<void(const RunResult&)>& report);

/// "romano simulate --seeds 17 ...": what replays one run.
[[nodiscard]] std::string replay_command(std::uint64_t seed, const RunOptions& options);

}  // namespace romano::sim
