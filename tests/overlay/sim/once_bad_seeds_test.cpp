// Seeds of random faults that once broke a promise or an invariant. What each of them found has a
// test of its own beside the code that was wrong, with the seed in its comment; here the whole runs
// are repeated.

#include <gtest/gtest.h>

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "overlay/sim/run.h"

namespace romano::sim::once_bad_seeds_test {
namespace {

struct OnceBad {
    std::string name;
    RunOptions options;
    std::vector<std::uint64_t> seeds;
};
void PrintTo(const OnceBad& once_bad, std::ostream* out) {  // for GoogleTest
    *out << once_bad.name;
}

std::vector<OnceBad> once_bad() {
    const std::vector<Fault> late_crash_stop{Fault::late, Fault::crash, Fault::stop};
    return {
        {"Mixed1", {}, {51279, 52126, 52467, 60194, 60241, 70287, 70703, 70869, 71993, 82022}},
        {"Mixed2", {}, {90031, 116938, 138174, 145609, 205595, 206332, 300376, 404563, 407790}},
        {"Mixed3", {}, {414907, 415533, 811931, 817448, 900899, 935207, 937788, 962900}},
        {"Mixed4", {}, {970610, 990523, 993428, 1042460, 1107968, 1114317, 1120970, 1403805}},
        {"Mixed5", {}, {1522201, 2105858, 2110352, 3000388, 3020203, 3107262, 3125396, 3125713}},
        {"Mixed6", {}, {9100883, 9736261, 9755735, 9951843}},
        {"LateCrashStop", {.faults = late_crash_stop}, {9100883, 9103541}},
        {"LateCrashStopPhi", {.detector = "phi-accrual", .faults = late_crash_stop}, {8040464}},
        {"LateCrash", {.brokers = 5, .acks = 2, .faults = {Fault::late, Fault::crash}}, {8020270}},
        {"StopOfFour", {.brokers = 4, .faults = {Fault::stop}}, {627}},
        {"StopOfFive", {.brokers = 5, .acks = 2, .faults = {Fault::stop}}, {4201899}},
        {"Relapse1", {.faults = {Fault::relapse}}, {9850621, 9851157, 9851395, 9851485, 9870835}},
        {"Relapse2",
         {.faults = {Fault::relapse}},
         {9872321, 9880263, 9881208, 9881270, 9882576, 9941534, 9972482, 9974474}},
        {"Relapse3",
         {.faults = {Fault::relapse}},
         {261, 366, 514, 709, 1971, 9978575, 9978847, 9979376, 9990563, 9992292, 9992392}},
        {"AsShipped",
         {.as_shipped = true},
         {2511, 5557, 6120, 6289, 8801, 9568, 10773, 12079, 13594, 14253, 15911, 17151, 18711,
          19192, 19420}},
        {"TwoWithRaft", {.brokers = 2, .elector = "raft"}, {1200474, 1200611, 1200906}},
        {"AsShippedRaft", {.as_shipped = true, .elector = "raft"}, {2747}},
        {"AsShippedOfWhoRoamsFromAStandstill", {.as_shipped = true}, {3078}},
        {"AsShippedOfOneWhoWasReplaced", {.as_shipped = true}, {3225, 3260, 3468, 4098, 42250}},
    };
}

class OnceBadSeeds : public testing::TestWithParam<OnceBad> {};

TEST_P(OnceBadSeeds, KeepEveryPromiseNow) {
    const RunOptions& options = GetParam().options;
    for (const std::uint64_t seed : GetParam().seeds) {
        const RunResult run = run_seed(seed, options);
        EXPECT_TRUE(run.is_good())
            << "seed " << seed << " (" << run.setting << ")\n"
            << to_text(run.violations) << "again: " << replay_command(seed, options);
    }
}

void keep(Invariant invariant, std::uint64_t seed, const RunOptions& options) {
    const RunResult run = run_seed(seed, options);
    EXPECT_EQ(run.breaches[static_cast<std::size_t>(invariant)], "")
        << "seed " << seed << " (" << run.setting << ")";
}

// A broker spoke in its place beside whoever had gone on for it, or a view gave one address to two
// heirs; in 2758 and 15391 an owner spoke that had said that it waits, and in 40584 a broker read a
// log later than a hand-over is waited for.
TEST(OnceBrokenSeeds, HaveOneSpeakerNow) {
    for (const std::uint64_t seed : {2758, 3109, 4537, 15391, 40584}) {
        keep(Invariant::one_speaker, seed, {.as_shipped = true});
    }
    for (const std::uint64_t seed : {366, 1041}) {
        keep(Invariant::one_speaker, seed, {.faults = {Fault::relapse}});
    }
    keep(Invariant::one_speaker, 814, {.faults = {Fault::late}});
    for (const std::uint64_t seed : {297, 1429, 1767}) {
        keep(Invariant::one_speaker, seed, {.faults = {Fault::starve}});
    }
}

TEST(OnceBrokenSeeds, HaveOneOwnerAViewNow) {
    for (const std::uint64_t seed : {9728, 40584}) {
        keep(Invariant::one_owner, seed, {.as_shipped = true});
    }
    for (const std::uint64_t seed : {322, 1271, 1709}) {
        keep(Invariant::one_owner, seed, {.faults = {Fault::relapse}});
    }
    for (const std::uint64_t seed : {191, 736, 974, 981}) {
        keep(Invariant::one_owner, seed, {.faults = {Fault::starve}});
    }
}

// A broker took those for gone whom it had not met, or not heard because it stood still.
TEST(OnceBrokenSeeds, HoldAMessageBeforeWhatIsSaidOfItNow) {
    keep(Invariant::named_first, 10308, {.as_shipped = true});
    keep(Invariant::named_first, 832, {.faults = {Fault::relapse}});
    keep(Invariant::named_first, 194, {.faults = {Fault::starve}});
}

// An address came back with an older copy of a session than another home had; in the last one a
// client's home in the view was not asked for it.
TEST(OnceBrokenSeeds, SpeakToAClientFromOneHomeNow) {
    for (const std::uint64_t seed : {1827, 3784, 8486, 11223, 20945}) {
        keep(Invariant::one_shard, seed, {.as_shipped = true});
    }
}

// Of two copies that a broker passed on the one stayed that had left before, and lacked what came
// since.
TEST(OnceBrokenSeeds, GoOnFromWhatWasLeftNow) {
    keep(Invariant::as_at_the_seal, 11222, {.as_shipped = true});
}

// The tail of a later view came before its announcement.
TEST(OnceBrokenSeeds, EndLogsAsAgreedNow) {
    for (const std::uint64_t seed : {234, 237, 583, 652, 671, 680, 952}) {
        keep(Invariant::agreed_end, seed, {.faults = {Fault::relapse}});
    }
    for (const std::uint64_t seed : {78, 113, 155, 228, 554, 907, 974}) {
        keep(Invariant::agreed_end, seed, {.faults = {Fault::starve}});
    }
    keep(Invariant::agreed_end, 787, {.faults = {Fault::late}});
}

INSTANTIATE_TEST_SUITE_P(Sweep, OnceBadSeeds, testing::ValuesIn(once_bad()),
                         [](const auto& group) { return group.param.name; });

}  // namespace
}  // namespace romano::sim::once_bad_seeds_test
