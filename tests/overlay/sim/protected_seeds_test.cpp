// Worlds whose robots and brokers protect their packets, and in which a stranger plays back what it
// recorded: every promise, and no nonce twice.

#include <gtest/gtest.h>

#include "overlay/sim/run.h"

namespace romano::sim::protected_seeds_test {
namespace {

using namespace std::chrono_literals;

RunOptions protected_world(std::vector<Fault> faults) {
    RunOptions options;
    options.is_protected = true;
    options.faults = std::move(faults);
    options.faults_last = 2500ms;
    return options;
}

void keep_every_promise(const SeedRange& seeds, const RunOptions& options) {
    std::uint64_t sealed = 0;
    run_seeds(seeds, options, [&](const RunResult& run) {
        sealed += run.sealed;
        EXPECT_TRUE(run.is_good())
            << "seed " << run.seed << " (" << run.setting << ")\n"
            << to_text(run.violations) << "again: " << replay_command(run.seed, options);
    });
    EXPECT_GT(sealed, 1'000U);
}

TEST(ProtectedWorlds, KeepEveryPromiseAndRepeatNoNonce) {
    keep_every_promise({1, 10}, protected_world({}));
}

TEST(ProtectedWorlds, RepeatNoNonceWhereTwoBrokersSpeakToOneRobot) {
    keep_every_promise({1, 8},
                       protected_world({Fault::partition, Fault::one_way_cut, Fault::crash}));
}

TEST(ProtectedWorlds, RepeatNoNonceThroughCrashesAndRoaming) {
    keep_every_promise({11, 20}, protected_world({Fault::crash, Fault::roam}));
}

TEST(ProtectedWorlds, CanBeReplayed) {
    EXPECT_EQ(replay_command(7, protected_world({})),
              "romano simulate --seeds 7 --protected --faults-last-ms 2500 --trace");
}

}  // namespace
}  // namespace romano::sim::protected_seeds_test
