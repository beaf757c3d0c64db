// `romano loops` as people call it, in small.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <utility>

#include "experiments/sweep/csv.h"
#include "tests/experiments/system/processes.h"
#include "tests/temporary_folder.h"

namespace romano::experiments::loops_system_test {
namespace {

using ::testing::HasSubstr;

std::string text_of(const std::filesystem::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
}

TEST(LoopsCommand, IsTheSameForTheSameSeedAlsoWhenItWasInterrupted) {
    const tests::TemporaryFolder folder;
    const std::string small = "loops --poles 2 --seconds 4 --runs 2 --brokers 1,2 --output ";
    const std::string once = folder / "once";
    const std::string again = folder / "again";
    const Ran ran = run_romano(small + once + " --periods 20,40 --losses 0,10");
    ASSERT_EQ(ran.exit_code, 0) << ran.output;
    EXPECT_EQ(
        run_romano(small + again + " --parts margins --periods 40 --losses 10 --jobs 1").exit_code,
        0);
    EXPECT_EQ(run_romano(small + again + " --periods 20,40 --losses 0,10").exit_code, 0);
    for (const char* file : {"margins.csv", "points.csv", "deviation_simulated.csv",
                             "formation_simulated.csv", "report.html"}) {
        const std::string text = text_of(folder / "once" / file);
        EXPECT_FALSE(text.empty()) << file;
        EXPECT_EQ(text_of(folder / "again" / file), text) << file;
    }
    EXPECT_THAT(ran.output, HasSubstr("How much delay a balanced pole bears"));
    EXPECT_THAT(ran.output, HasSubstr("crash for good"));
    const auto rows = parse_csv(text_of(folder / "once" / "margins.csv"));
    ASSERT_EQ(rows.size(), 1U + 4U);  // head, two periods at two losses
    EXPECT_TRUE(
        std::ranges::all_of(rows, [&](const CsvRow& row) { return row.size() == rows[0].size(); }));
}

class RefusedLoops : public ::testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(RefusedLoops, SayOneSentenceAndExitWith2) {
    const auto [arguments, sentence] = GetParam();
    const Ran ran = run_romano(std::string{"loops "} + arguments);
    EXPECT_EQ(ran.exit_code, 2);
    EXPECT_THAT(ran.output, HasSubstr(sentence));
    EXPECT_EQ(std::count(ran.output.begin(), ran.output.end(), '\n'), 1) << ran.output;
}

INSTANTIATE_TEST_SUITE_P(
    Loops, RefusedLoops,
    ::testing::Values(
        std::pair{"--parts pole", "--parts: pole not in {margins,deviation,formation}"},
        std::pair{"--periods 6", "--periods: Value 6 not in range 7 to 1000"},
        std::pair{"--losses 95", "--losses: Value 95 not in range 0"},
        std::pair{"--poles 0", "--poles: Value 0 not in range 1 to 1000"},
        std::pair{"--brokers 33", "--brokers: Value 33 not in range 1 to 32"},
        std::pair{"--runs 0", "--runs: Value 0 not in range 1 to 10000"},
        std::pair{"--worlds mars", "--worlds: mars not in {simulated,radio,processes}"},
        std::pair{"--worlds processes --broker /none",
                  "--worlds processes: no broker to run: `/none` is no program"},
        std::pair{"--output /proc/none", "cannot write into --output `/proc/none`"}));

}  // namespace
}  // namespace romano::experiments::loops_system_test
