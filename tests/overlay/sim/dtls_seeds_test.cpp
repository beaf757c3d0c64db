// Worlds whose robots speak DTLS, and in which a stranger plays back, bends and reflects what it
// recorded: every promise, no number twice, and nothing taken that no robot said.

#include <gtest/gtest.h>

#include "overlay/sim/run.h"

namespace romano::sim::dtls_seeds_test {
namespace {

using namespace std::chrono_literals;

RunOptions dtls_world(std::vector<Fault> faults) {
    RunOptions options;
    options.speaks_dtls = true;
    options.faults = std::move(faults);
    options.faults_last = 2500ms;
    return options;
}

std::uint64_t keep_every_promise(const SeedRange& seeds, const RunOptions& options) {
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

TEST(DtlsWorlds, KeepEveryPromiseAndRepeatNoNumber) {
    keep_every_promise({1, 10}, dtls_world({}));
}

TEST(DtlsWorlds, RepeatNoNumberWhereTwoBrokersSpeakToOneRobot) {
    keep_every_promise({1, 8}, dtls_world({Fault::partition, Fault::one_way_cut, Fault::crash}));
}

TEST(DtlsWorlds, LoseNobodyWhoChangesItsAddress) {
    EXPECT_GT(keep_every_promise({11, 20}, dtls_world({Fault::crash, Fault::roam})), 10U);
}

TEST(DtlsWorlds, CanBeReplayed) {
    EXPECT_EQ(replay_command(7, dtls_world({})),
              "romano simulate --seeds 7 --dtls --faults-last-ms 2500 --trace");
}

}  // namespace
}  // namespace romano::sim::dtls_seeds_test
