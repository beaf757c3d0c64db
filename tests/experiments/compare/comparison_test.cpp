#include "experiments/compare/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "experiments/compare/compare_report.h"
#include "tests/temporary_folder.h"

namespace romano::experiments::comparison_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

RunRow run(std::uint32_t brokers, std::uint32_t repetition, double delay_ms, double ratio = 1) {
    RunRow row;
    row.cell.brokers = brokers;
    row.cell.repetition = repetition;
    row.cell.number = 10 * brokers + repetition;
    row.delay_p50_ms = delay_ms;
    row.delivery_ratio = ratio;
    return row;
}

/// Runs whose delays are `mean` and a little to either side.
std::vector<RunRow> runs(std::uint32_t brokers, std::uint32_t count, double mean,
                         double ratio = 1) {
    std::vector<RunRow> rows;
    for (std::uint32_t i = 1; i <= count; ++i) {
        rows.push_back(run(brokers, i, mean + 0.01 * (i % 2 == 0 ? 1 : -1),
                           ratio - 0.001 * (i % 2 == 0 ? 1 : 0)));
    }
    return rows;
}

Compared compared(const std::vector<RunRow>& a, const std::vector<RunRow>& b) {
    Compared result{.name_a = "before",
                    .name_b = "after",
                    .a = configurations_of(a),
                    .b = configurations_of(b),
                    .comparison = {}};
    result.comparison = compare(result.a, result.b, result.confidence);
    return result;
}

Verdict verdict_on(const Compared& result, std::string_view metric) {
    for (const Difference& each : result.comparison.differences) {
        if (each.metric->name == metric) return each.verdict;
    }
    ADD_FAILURE() << "nothing on " << metric;
    return Verdict::too_few_runs;
}

TEST(Comparison, LessDelayIsBetterAndLessDeliveryIsWorse) {
    const auto result = compared(runs(3, 6, 2.0, 1.0), runs(3, 6, 1.0, 0.9));
    EXPECT_EQ(verdict_on(result, "delay, median"), Verdict::better);
    EXPECT_EQ(verdict_on(result, "delivered"), Verdict::worse);
}

TEST(Comparison, TheSameRunsShowNoDifference) {
    const auto result = compared(runs(3, 6, 2.0), runs(3, 6, 2.0));
    EXPECT_EQ(verdict_on(result, "delay, median"), Verdict::none_seen);
}

TEST(Comparison, FewRunsAreNotJudged) {
    const auto result = compared(runs(3, 4, 2.0), runs(3, 6, 1.0));
    EXPECT_EQ(verdict_on(result, "delay, median"), Verdict::too_few_runs);
    EXPECT_THAT(verdict_of(result), HasSubstr("5 on each side are needed"));
}

TEST(Comparison, ConfigurationsOfOneSideAreNamed) {
    auto a = runs(3, 5, 2.0);
    auto b = a;
    for (const RunRow& row : runs(1, 5, 1.0)) a.push_back(row);
    for (const RunRow& row : runs(5, 5, 1.0)) b.push_back(row);
    const auto result = compared(a, b);
    EXPECT_THAT(result.comparison.only_a, ElementsAre("1 broker"));
    EXPECT_THAT(result.comparison.only_b, ElementsAre("5 brokers"));
}

TEST(Comparison, OfVeryManyConfigurationsIsStillRead) {
    std::vector<RunRow> a;
    for (std::uint32_t brokers = 1; brokers <= 300; ++brokers) {
        for (const RunRow& row : runs(brokers, 5, 2.0)) a.push_back(row);
    }
    auto b = a;
    for (std::uint32_t brokers = 301; brokers <= 312; ++brokers) {
        for (const RunRow& row : runs(brokers, 5, 2.0)) b.push_back(row);
    }
    const tests::TemporaryFolder folder;
    const auto result = compared(a, b);
    EXPECT_THAT(verdict_of(result), HasSubstr("310 brokers; and 2 more."));
    EXPECT_THAT(page_of(result, folder / "plots"), HasSubstr("The first 500 of 600; "));
}

TEST(Comparison, RunsThatFailedDoNotCount) {
    auto b = runs(3, 5, 2.0);
    for (std::uint32_t i = 6; i <= 9; ++i) {
        b.push_back(run(3, i, 1000));
        b.back().status = "no view";
    }
    const auto result = compared(runs(3, 5, 2.0), b);
    EXPECT_EQ(verdict_on(result, "delay, median"), Verdict::none_seen);
}

TEST(Comparison, TheTableListsDifferencesAndOnRequestAll) {
    const auto result = compared(runs(3, 6, 2.0, 1.0), runs(3, 6, 1.0, 1.0));
    EXPECT_EQ(table_of(result, false).rows.size(), 1u);
    EXPECT_EQ(table_of(result, true).rows.size(), 2u);
    EXPECT_THAT(to_csv(result), HasSubstr("\"delay, median\",ms,6,6,2,1,-1,"));
    EXPECT_THAT(to_json(result), HasSubstr("\"verdict\": \"better\""));
}

TEST(Comparison, ThePageShowsBothInEachFigure) {
    const tests::TemporaryFolder folder;
    const auto result = compared(runs(3, 6, 2.0), runs(3, 6, 1.0));
    const std::string page = page_of(result, folder / "plots");
    EXPECT_THAT(page, HasSubstr("<h2>delay, median</h2>"));
    EXPECT_THAT(page, Not(HasSubstr("<h2>failover, by the probe</h2>"))) << "nobody measured it";
    EXPECT_TRUE(std::filesystem::exists(folder / "plots" / "compare_2.gp"));
}

}  // namespace
}  // namespace romano::experiments::comparison_test
