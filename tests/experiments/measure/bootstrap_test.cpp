#include "experiments/measure/bootstrap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace romano::experiments::bootstrap_test {
namespace {

std::vector<double> normal(std::mt19937_64& random, std::size_t count, double mean,
                           double deviation) {
    std::normal_distribution<double> distribution(mean, deviation);
    std::vector<double> values(count);
    for (double& value : values) value = distribution(random);
    return values;
}

/// In how many of 100 experiments the interval covers the truth.
template <typename Covers>
double coverage(const Covers& covers) {
    std::mt19937_64 random(7);
    constexpr int experiments = 300;
    int covered = 0;
    for (int i = 0; i < experiments; ++i) covered += covers(random) ? 1 : 0;
    return 100.0 * covered / experiments;
}

TEST(Bootstrap, TheIntervalOfAMeanCoversTheTruthAsOftenAsItSays) {
    for (const std::size_t runs : {runs_for_an_interval, std::size_t{10}, std::size_t{40}}) {
        const double covered = coverage([&](auto& random) {
            return interval_of_mean(normal(random, runs, 3, 2), 0.95)->contains(3);
        });
        EXPECT_GE(covered, 90) << runs << " runs";
        EXPECT_LE(covered, 99) << runs << " runs";
    }
}

TEST(Bootstrap, OfTwoThatAreTheSameFewLookDifferent) {
    const double covered = coverage([](auto& random) {
        const auto a = normal(random, 6, 10, 1);
        return interval_of_difference(a, normal(random, 6, 10, 1), 0.95)->contains(0);
    });
    EXPECT_GE(covered, 92);
}

TEST(Bootstrap, ADifferenceOfManyDeviationsIsSeen) {
    std::mt19937_64 random(1);
    const auto a = normal(random, 6, 10, 1);
    const auto interval = interval_of_difference(a, normal(random, 6, 20, 1), 0.95);
    EXPECT_GT(interval->low, 7);
    EXPECT_LT(interval->high, 13);
}

TEST(Bootstrap, TheSameRunsGiveTheSameInterval) {
    const std::vector<double> values = {1, 2, 4, 8, 16};
    const auto once = interval_of_mean(values, 0.95);
    const auto again = interval_of_mean(values, 0.95);
    EXPECT_EQ(once->low, again->low);
    EXPECT_EQ(once->high, again->high);
}

TEST(Bootstrap, AMoreConfidentIntervalIsWider) {
    const std::vector<double> values = {1, 2, 4, 8, 16, 9, 3};
    const auto sure = interval_of_mean(values, 0.99);
    const auto less = interval_of_mean(values, 0.8);
    EXPECT_LT(sure->low, less->low);
    EXPECT_GT(sure->high, less->high);
}

TEST(Bootstrap, OneRunHasNoInterval) {
    EXPECT_FALSE(interval_of_mean(std::vector<double>{1}, 0.95));
    EXPECT_FALSE(interval_of_difference(std::vector<double>{1}, std::vector<double>{1, 2}, 0.95));
    EXPECT_FALSE(runs_needed(std::vector<double>{1}, 0.1, 0.95));
    EXPECT_FALSE(runs_needed(std::vector<double>{-1, 1}, 0.1, 0.95)) << "no share of a mean of 0";
}

// n = (t s / w)^2: with s / mean = 0.1 and w / mean = 0.1, t(n - 1) / sqrt(n) <= 1.
TEST(Bootstrap, RunsNeededFollowFromTheSpread) {
    const double deviation = std::sqrt(0.5);
    const std::vector<double> values = {10 * deviation - 0.5, 10 * deviation + 0.5};
    EXPECT_EQ(runs_needed(values, 0.1, 0.95), 7u);
    EXPECT_GT(*runs_needed(values, 0.01, 0.95), 350u);
    EXPECT_EQ(runs_needed(std::vector<double>{5, 5, 5}, 0.1, 0.95), 2u);
}

}  // namespace
}  // namespace romano::experiments::bootstrap_test
