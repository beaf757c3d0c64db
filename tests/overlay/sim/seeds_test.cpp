// Random clusters, robots and faults by seed: in each of them every promise of the design is kept,
// and no invariant breaks. A failure prints the seed and the command that repeats it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <ostream>
#include <set>
#include <string>
#include <vector>

#include "overlay/sim/run.h"

namespace romano::sim::seeds_test {
namespace {

using namespace std::chrono_literals;

/// A part of the sweep: small enough that several run side by side.
struct Shard {
    std::string name;
    std::vector<Fault> faults;
    SeedRange seeds;
};
void PrintTo(const Shard& shard, std::ostream* out) {  // for GoogleTest
    *out << shard.name;
}

std::vector<Shard> shards() {
    const std::vector<std::pair<std::string, std::vector<Fault>>> kinds{
        {"Crash", {Fault::crash}},
        {"Stop", {Fault::stop}},
        {"Leave", {Fault::leave}},
        {"BadLinks", {Fault::bad_links}},
        {"Partition", {Fault::partition}},
        {"OneWayCut", {Fault::one_way_cut}},
        {"Starve", {Fault::starve}},
        {"Robots", {Fault::roam, Fault::sleep, Fault::die}},
        {"RobotsAndCrash", {Fault::roam, Fault::sleep, Fault::die, Fault::crash}},
        {"Mixed", {}},
        {"Late", {Fault::late, Fault::crash, Fault::roam}},
        {"Relapse", {Fault::relapse}},
        {"Deaf", {Fault::deaf}},
        {"Share", {Fault::share, Fault::crash, Fault::stop, Fault::roam}},
        {"ShareAndPart", {Fault::share, Fault::partition, Fault::crash, Fault::sleep}},
    };
    constexpr std::uint64_t shards_each = 4;
    constexpr std::uint64_t seeds_each = 13;
    std::vector<Shard> all;
    std::uint64_t next = 1;
    for (const auto& [name, faults] : kinds) {
        for (std::uint64_t i = 1; i <= shards_each; ++i, next += seeds_each) {
            all.push_back({name + std::to_string(i), faults, {next, next + seeds_each - 1}});
        }
    }
    return all;
}

/// `may_break`: the one invariant that the faults may break (overlay/sim/README.md).
void expect_sound(const RunResult& run, const RunOptions& options,
                  std::optional<Invariant> may_break = std::nullopt) {
    const std::string again = "again: " + replay_command(run.seed, options);
    EXPECT_TRUE(run.is_good()) << "seed " << run.seed << " (" << run.setting << ")\n"
                               << to_text(run.violations) << again;
    for (std::size_t i = 0; i < invariant_count; ++i) {
        if (may_break == Invariant{static_cast<std::uint8_t>(i)}) continue;
        EXPECT_EQ(run.breaches[i], "")
            << invariant_names[i] << " in seed " << run.seed << " (" << run.setting << ")\n"
            << again;
    }
}

class Seeds : public testing::TestWithParam<Shard> {};

TEST_P(Seeds, KeepEveryPromise) {
    RunOptions options;
    options.faults = GetParam().faults;
    options.faults_last = 2500ms;  // a seed more is worth more than a second more
    const bool starves = std::ranges::count(options.faults, Fault::starve) > 0;
    const auto may_break = starves ? std::optional{Invariant::safe_is_safe} : std::nullopt;
    run_seeds(GetParam().seeds, options,
              [&](const RunResult& run) { expect_sound(run, options, may_break); });
}

INSTANTIATE_TEST_SUITE_P(Sweep, Seeds, testing::ValuesIn(shards()),
                         [](const auto& shard) { return shard.param.name; });

// The sessions that an heir adopts then have no address to speak from.
class Unable : public testing::TestWithParam<SeedRange> {};

TEST_P(Unable, HalfOfTheMachinesTakeNoAddressesOfPeers) {
    RunOptions options;
    options.are_some_unable = true;
    run_seeds(GetParam(), options, [&](const RunResult& run) { expect_sound(run, options); });
}

INSTANTIATE_TEST_SUITE_P(Sweep, Unable,
                         testing::Values(SeedRange{1, 8}, SeedRange{24, 31}, SeedRange{91, 98}),
                         [](const auto& range) {
                             return "From" + std::to_string(range.param.first);
                         });

// Each profile with each detector and elector, on machines of several kinds.
class AsShipped : public testing::TestWithParam<SeedRange> {};

TEST_P(AsShipped, KeepsEveryPromise) {
    RunOptions options;
    options.as_shipped = true;
    options.faults_last = 2500ms;
    run_seeds(GetParam(), options, [&](const RunResult& run) { expect_sound(run, options); });
}

// Two clocks are apart by a sixth in their pace, and leases are as long as ever (I1).
TEST_P(AsShipped, KeepsEveryPromiseWithSlewedClocks) {
    RunOptions options;
    options.as_shipped = true;
    options.are_clocks_slewed = true;
    options.faults_last = 2500ms;
    run_seeds(GetParam(), options, [&](const RunResult& run) { expect_sound(run, options); });
}

INSTANTIATE_TEST_SUITE_P(Sweep, AsShipped,
                         testing::Values(SeedRange{1, 8}, SeedRange{9, 16}, SeedRange{17, 24},
                                         SeedRange{25, 32}),
                         [](const auto& range) {
                             return "From" + std::to_string(range.param.first);
                         });

TEST(Simulation, IsTheSameByteForByteForTheSameSeed) {
    const auto trace_of = [](std::uint64_t seed) {
        std::string text;
        RunOptions options;
        options.faults_last = 2s;
        options.trace = [&text](std::string_view line) { (text += line) += '\n'; };
        const RunResult run = run_seed(seed, options);
        return std::pair{run.trace_hash, text};
    };
    const auto [hash, text] = trace_of(7);
    const auto [hash_again, text_again] = trace_of(7);
    EXPECT_EQ(hash, hash_again);
    EXPECT_EQ(text, text_again);
    EXPECT_FALSE(text.empty());
    EXPECT_NE(trace_of(8).first, hash);
}

TEST(Simulation, TheCommandThatRepeatsARunSaysAllThatTheSeedDoesNotDecide) {
    EXPECT_EQ(replay_command(7, {}), "romano simulate --seeds 7 --trace");
    RunOptions options;
    options.as_shipped = true;
    options.are_clocks_slewed = true;
    options.profile = "wifi";
    options.brokers = 3;
    options.robots = 4;
    options.elector = "raft";
    options.detector = "link";
    options.acks = cluster::all_peers;
    options.faults = {Fault::crash, Fault::one_way_cut};
    options.faults_last = 2500ms;
    EXPECT_EQ(
        replay_command(7, options),
        "romano simulate --seeds 7 --as-shipped --slewed --profile wifi --brokers 3 --robots 4 "
        "--elector raft --detector link "
        "--acks all --fault crash --fault one-way-cut --faults-last-ms 2500 --trace");
}

TEST(Simulation, TakesTheTimesOfAProfile) {
    RunOptions options;
    options.faults_last = 2s;
    options.profile = "mesh";
    const RunResult run = run_seed(3, options);
    EXPECT_EQ(run.profile, "mesh");
    EXPECT_EQ(run.detector, "fixed");
    EXPECT_GE(run.virtual_time, 60s) << "as much happens in it: silence of 3 s means death";
}

TEST(Simulation, DrawsWhatShipsFromTheSeed) {
    RunOptions options;
    options.as_shipped = true;
    options.faults_last = 500ms;
    std::set<std::string> seen;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        const RunResult run = run_seed(seed, options);
        seen.insert({run.profile, run.detector, run.elector});
    }
    EXPECT_THAT(seen, testing::IsSupersetOf({"lan", "wifi", "mesh", "fixed", "phi-accrual", "link",
                                             "component", "raft", "bully"}));
    options.elector = "raft";
    EXPECT_EQ(run_seed(1, options).elector, "raft") << "what is said counts";
}

TEST(Simulation, IsTheSameWhetherOrNotSomebodyListens) {
    RunOptions options;
    options.faults_last = 2s;
    const std::uint64_t silent = run_seed(7, options).trace_hash;
    options.trace = [](std::string_view) {};
    EXPECT_EQ(run_seed(7, options).trace_hash, silent);
}

}  // namespace
}  // namespace romano::sim::seeds_test
