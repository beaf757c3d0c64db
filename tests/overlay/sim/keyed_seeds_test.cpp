// Worlds whose robots and brokers have keys, for protected packets or for DTLS, and in which a
// stranger plays back what it recorded, and bends and reflects what it can: every promise, no
// number twice under one key, and nothing taken that no robot said.

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "overlay/sim/run.h"

namespace romano::sim::keyed_seeds_test {
namespace {

using namespace std::chrono_literals;

struct Speech {
    std::string name;
    bool RunOptions::*is_spoken;
};

struct KeyedWorlds : testing::TestWithParam<Speech> {
    static RunOptions world(std::vector<Fault> faults) {
        RunOptions options;
        options.*GetParam().is_spoken = true;
        options.faults = std::move(faults);
        options.faults_last = 2500ms;
        return options;
    }
    /// How often robots with a Connection ID moved.
    static std::uint64_t keep_every_promise(const SeedRange& seeds, const RunOptions& options) {
        std::uint64_t sealed = 0;
        std::uint64_t moved = 0;
        run_seeds(seeds, options, [&](const RunResult& run) {
            sealed += run.sealed;
            moved += run.moved;
            EXPECT_TRUE(run.is_good())
                << "seed " << run.seed << " (" << run.setting << ")\n"
                << to_text(run.violations) << "again: " << replay_command(run.seed, options);
        });
        EXPECT_GT(sealed, 1'000U);
        return moved;
    }
};
INSTANTIATE_TEST_SUITE_P(With, KeyedWorlds,
                         testing::Values(Speech{"protected", &RunOptions::is_protected},
                                         Speech{"dtls", &RunOptions::speaks_dtls}),
                         [](const auto& each) { return each.param.name; });

TEST_P(KeyedWorlds, KeepEveryPromiseAndRepeatNoNumber) {
    keep_every_promise({1, 10}, world({}));
}

TEST_P(KeyedWorlds, RepeatNoNumberWhereTwoBrokersSpeakToOneRobot) {
    keep_every_promise({1, 8}, world({Fault::partition, Fault::one_way_cut, Fault::crash}));
}

TEST_P(KeyedWorlds, LoseNobodyWhoChangesItsAddress) {
    const std::uint64_t moved = keep_every_promise({11, 20}, world({Fault::crash, Fault::roam}));
    if (GetParam().name == "dtls") {
        EXPECT_GT(moved, 10U);
    }
}

TEST_P(KeyedWorlds, CanBeReplayed) {
    EXPECT_EQ(replay_command(7, world({})),
              "romano simulate --seeds 7 --" + GetParam().name + " --faults-last-ms 2500 --trace");
}

}  // namespace
}  // namespace romano::sim::keyed_seeds_test
