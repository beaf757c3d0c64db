// Worlds whose robots may not publish and read everything, and whose rights change while brokers
// die and robots roam: nobody gets or says what it may not, nothing else is lost or refused.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "overlay/sim/drawn_rights.h"
#include "overlay/sim/promises.h"
#include "overlay/sim/run.h"

namespace romano::sim::rights_seeds_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

RunOptions world_with_rights(std::vector<Fault> faults) {
    RunOptions options;
    options.is_protected = true;
    options.has_rights = true;
    options.faults = std::move(faults);
    options.faults_last = 2500ms;
    return options;
}

void keep_every_promise(const SeedRange& seeds, const RunOptions& options) {
    run_seeds(seeds, options, [&](const RunResult& run) {
        EXPECT_TRUE(run.is_good())
            << "seed " << run.seed << " (" << run.setting << ")\n"
            << to_text(run.violations) << "again: " << replay_command(run.seed, options);
    });
}

TEST(WorldsWithRights, KeepEveryPromise) {
    keep_every_promise({1, 10}, world_with_rights({}));
}

TEST(WorldsWithRights, KeepRightsThroughCrashesAndRoaming) {
    keep_every_promise({11, 25}, world_with_rights({Fault::crash, Fault::roam}));
}

TEST(WorldsWithRights, KeepRightsOfRobotsThatSpeakDtls) {
    RunOptions options = world_with_rights({Fault::crash, Fault::stop, Fault::sleep});
    options.is_protected = false;
    options.speaks_dtls = true;
    keep_every_promise({31, 40}, options);
}

TEST(WorldsWithRights, CanBeReplayed) {
    EXPECT_EQ(replay_command(7, world_with_rights({})),
              "romano simulate --seeds 7 --protected --rights --faults-last-ms 2500 --trace");
}

/// Two robots on one topic, by seeds whose first and second rights are of each kind.
class DrawnRightsTest : public testing::Test {
protected:
    static constexpr std::string_view topics[] = {"pose"};
    const std::vector<std::string> robots{"talker", "listener"};

    /// What the judges say of one message that the listener got, and that was acknowledged.
    static std::vector<Promise> judged(const DrawnRights& rights, Instant at, bool is_received,
                                       bool is_refused) {
        Ledger ledger;
        Sent message{.publisher = "talker",
                     .number = 1,
                     .topic = "pose",
                     .qos = Qos::exactly_once,
                     .at = at,
                     .acknowledged = std::nullopt};
        message.refused = is_refused;
        if (!is_refused) message.acknowledged = at + 1s;
        ledger.sent[{"talker", 1}] = message;
        ledger.subscriptions.push_back({.subscriber = "listener",
                                        .filter = "pose",
                                        .granted = Qos::exactly_once,
                                        .from = Instant{0s},
                                        .until = std::nullopt});
        if (is_received) {
            ledger.receptions.push_back({.subscriber = "listener",
                                         .publisher = "talker",
                                         .number = 1,
                                         .qos = Qos::exactly_once,
                                         .at = at + 1s});
        }
        Violations violations;
        const Judgement judgement{.rights = &rights};
        judge_safety(ledger, judgement, violations);
        judge_completeness(ledger, judgement, violations);
        std::vector<Promise> promises;
        for (const Violation& violation : violations) promises.push_back(violation.promise);
        return promises;
    }

    /// Rights of the first seed from 1 of which `is_wanted`.
    template <typename Wanted>
    [[nodiscard]] DrawnRights drawn(Wanted is_wanted) const {
        for (std::uint64_t seed = 1;; ++seed) {
            DrawnRights rights(seed, robots, topics);
            if (is_wanted(rights)) return DrawnRights(seed, robots, topics);
        }
    }

    static Sent message(Instant at) {
        return {.publisher = "talker",
                .number = 1,
                .topic = "pose",
                .qos = Qos::exactly_once,
                .at = at,
                .acknowledged = std::nullopt};
    }
};

TEST_F(DrawnRightsTest, WhoMayNotReadGetsNothing) {
    const DrawnRights rights = drawn([](const DrawnRights& its) {
        return !its.possibly_reads("listener", message({})) && its.surely_publishes(message({}));
    });
    EXPECT_EQ(judged(rights, Instant{5s}, true, false), std::vector{Promise::rights_kept});
    EXPECT_TRUE(judged(rights, Instant{5s}, false, false).empty()) << "and has no claim to it";
}

TEST_F(DrawnRightsTest, WhoMayReadHasAClaimToIt) {
    const DrawnRights rights = drawn([](const DrawnRights& its) {
        return its.surely_reads("listener", message({})) && its.surely_publishes(message({}));
    });
    EXPECT_TRUE(judged(rights, Instant{5s}, true, false).empty());
    EXPECT_EQ(judged(rights, Instant{5s}, false, false), std::vector{Promise::nothing_lost});
    EXPECT_EQ(judged(rights, Instant{5s}, false, true), std::vector{Promise::rights_kept})
        << "refused what it may say";
}

TEST_F(DrawnRightsTest, WhoMayNotPublishIsRefused) {
    const DrawnRights rights = drawn([](const DrawnRights& its) {
        return its.surely_reads("listener", message({})) && !its.possibly_publishes(message({}));
    });
    EXPECT_TRUE(judged(rights, Instant{5s}, false, true).empty());
    EXPECT_EQ(judged(rights, Instant{5s}, false, false).front(), Promise::rights_kept);
}

TEST_F(DrawnRightsTest, ARightThatEndsMayHoldUntilTheLastBrokerHasHeardOfIt) {
    DrawnRights rights = drawn([](DrawnRights& its) {
        const bool reads = its.surely_reads("listener", message({}));
        its.change();
        its.on_taken_up(Instant{10s});
        return reads && !its.possibly_reads("listener", message(Instant{11s})) &&
               its.surely_publishes(message({}));
    });
    rights.change();
    rights.on_taken_up(Instant{10s});
    EXPECT_TRUE(judged(rights, Instant{9s}, true, false).empty());
    EXPECT_TRUE(judged(rights, Instant{9s}, false, false).empty());
    EXPECT_EQ(judged(rights, Instant{11s}, true, false), std::vector{Promise::rights_kept});
}

}  // namespace
}  // namespace romano::sim::rights_seeds_test
