#include "experiments/measure/percentile.h"

#include <gtest/gtest.h>

namespace romano::experiments::percentile_test {
namespace {

std::vector<double> one_to(int last) {
    std::vector<double> numbers;
    for (int i = last; i >= 1; --i) numbers.push_back(i);
    return numbers;
}

TEST(Percentiles, AreSamplesByNearestRank) {
    const Percentiles of{{15, 20, 35, 40, 50}};  // rank = ceil(share * 5)
    EXPECT_EQ(of.at(0.05), 15);
    EXPECT_EQ(of.at(0.30), 20);
    EXPECT_EQ(of.at(0.40), 20);
    EXPECT_EQ(of.at(0.50), 35);
    EXPECT_EQ(of.at(1.00), 50);
}

TEST(Percentiles, OfOneToAHundredAreTheirOwnShare) {
    const Percentiles of{one_to(100)};
    for (int percent = 1; percent <= 100; ++percent) EXPECT_EQ(of.at(percent / 100.0), percent);
}

TEST(Percentiles, TheNinetyNinthOfFewSamplesIsTheLargest) {
    EXPECT_EQ(Percentiles{one_to(10)}.at(0.99), 10);
    EXPECT_EQ(Percentiles{{7}}.at(0.01), 7);
}

TEST(Percentiles, OfNothingAreEmpty) {
    EXPECT_EQ(Percentiles{}.at(0.5), std::nullopt);
    EXPECT_EQ(Percentiles{}.min(), std::nullopt);
    EXPECT_EQ(Percentiles{}.max(), std::nullopt);
}

TEST(Percentiles, MinAndMaxAreTheEnds) {
    const Percentiles of{{3, 1, 2}};
    EXPECT_EQ(of.min(), 1);
    EXPECT_EQ(of.max(), 3);
    EXPECT_EQ(of.count(), 3u);
}

}  // namespace
}  // namespace romano::experiments::percentile_test
