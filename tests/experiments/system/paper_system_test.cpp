// `romano paper` as people call it, in small.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <utility>

#include "experiments/sweep/csv.h"
#include "tests/experiments/system/processes.h"
#include "tests/temporary_folder.h"

namespace romano::experiments::paper_system_test {
namespace {

using ::testing::HasSubstr;

std::string text_of(const std::filesystem::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Paper, IsTheSameForTheSameSeedAlsoWhenItWasInterrupted) {
    const tests::TemporaryFolder folder;
    const std::string small =
        "paper --parts table,energy --baud 230400 --runs 2 --messages 100 --output ";
    const std::string once = folder / "once";
    const std::string again = folder / "again";
    const Ran ran = run_romano(small + once + " --rates 100,300");
    ASSERT_EQ(ran.exit_code, 0) << ran.output;
    EXPECT_EQ(run_romano(small + again + " --rates 300 --jobs 1").exit_code, 0);
    EXPECT_EQ(run_romano(small + again + " --rates 100,300").exit_code, 0);
    for (const char* file :
         {"table.csv", "delay.csv", "statements.csv", "energy.csv", "report.html"}) {
        const std::string text = text_of(folder / "once" / file);
        EXPECT_FALSE(text.empty()) << file;
        EXPECT_EQ(text_of(folder / "again" / file), text) << file;
    }
    EXPECT_THAT(ran.output, HasSubstr("least delivery at 300/s"));
    const auto rows = parse_csv(text_of(folder / "once" / "statements.csv"));
    EXPECT_TRUE(
        std::ranges::all_of(rows, [&](const CsvRow& row) { return row.size() == rows[0].size(); }));
}

class RefusedPapers : public ::testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(RefusedPapers, SayOneSentenceAndExitWith2) {
    const auto [arguments, sentence] = GetParam();
    const Ran ran = run_romano(std::string{"paper "} + arguments);
    EXPECT_EQ(ran.exit_code, 2);
    EXPECT_THAT(ran.output, HasSubstr(sentence));
    EXPECT_EQ(std::count(ran.output.begin(), ran.output.end(), '\n'), 1) << ran.output;
}

INSTANTIATE_TEST_SUITE_P(
    Paper, RefusedPapers,
    ::testing::Values(
        std::pair{"--baud 0", "a UART of 0 baud cannot be: give 1200 to 10000000 baud, or none"},
        std::pair{"--channel 27", "channel 27 does not exist: IEEE 802.15.4 at 2.4 GHz has"},
        std::pair{"--rates 0", "--rates: Value 0 not in range"},
        std::pair{"--parts figure",
                  "--parts: figure not in {table,energy,cells,moves,backbone,"
                  "broadcast}"},
        std::pair{"--cell-channels 17", "--cell-channels: Value 17 not in range 1 to 16"},
        std::pair{"--robots 101", "--robots: Value 101 not in range 1 to 100"},
        std::pair{"--brokers 65", "--brokers: Value 65 not in range 1 to 64"},
        std::pair{"--runs 0", "--runs: Value 0 not in range 1 to 1000"},
        std::pair{"--output /proc/none", "cannot write into --output `/proc/none`"}));

}  // namespace
}  // namespace romano::experiments::paper_system_test
