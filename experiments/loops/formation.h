// Five robots in a wedge: the first one drives where it likes and controls the four others, each of
// which has a place beside and behind it. How far from their places are they, with and without a
// fault of the broker?
//
// A follower's sample is its location, a command its speed, both as ROMANO writes them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "experiments/loops/faulty_brokers.h"
#include "experiments/process/separate_runs.h"
#include "experiments/report/section.h"
#include "firmware/posix/body.h"

namespace romano::experiments {

/// A point beside a robot, as it sees it.
struct WedgePlace {
    double ahead_mm = 0;
    double left_mm = 0;
};

/// Where a follower should be, when the leader is at `leader`.
[[nodiscard]] firmware::Pose place_at(const firmware::Pose& leader, const WedgePlace& place);

/// The law: how the follower should drive while the leader drives at `speed`. A cart with two
/// wheels can move a point ahead of its axle in any direction at once: the law moves the one 50 mm
/// ahead as its place moves, and each second by twice what it is away from there.
[[nodiscard]] firmware::Speed speed_to_place(const firmware::Pose& leader,
                                             const firmware::Speed& speed, const WedgePlace& place,
                                             const firmware::Pose& follower);

struct FormationRun {
    double error_mm = 0;  // the greatest of any follower in the five seconds from the fault on
    std::uint32_t falls_back = 0;     // of all followers together
    std::vector<double> course_mm{};  // the greatest error of the four, each 20 ms from a second
                                      // before the fault
};
[[nodiscard]] FormationRun formation(const LoopGround& ground, std::size_t brokers,
                                     BrokerFault fault, std::uint64_t seed);

struct FormationPlan {
    std::vector<std::size_t> brokers{1, 3, 5};
    std::size_t runs = 100;
    std::uint64_t seed = 1;
};
[[nodiscard]] std::vector<SeparateRun> runs_of(const FormationPlan& plan, const LoopGround& ground);
/// When all runs are done.
[[nodiscard]] Section formation_section(const FormationPlan& plan, LoopWorld world,
                                        const std::filesystem::path& folder);

}  // namespace romano::experiments
