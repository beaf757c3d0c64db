#include "experiments/measure/latency_histogram.h"

#include <gtest/gtest.h>

namespace romano::experiments::latency_histogram_test {
namespace {

using namespace std::chrono_literals;

TEST(LatencyHistogram, PercentilesAreNeverTooGoodAndAtMostASixtyFourthTooBad) {
    LatencyHistogram histogram;
    for (int i = 1; i <= 100'000; ++i) histogram.add(i * 100ns);
    for (const double share : {0.01, 0.5, 0.9, 0.99, 0.999}) {
        const double exact = share * 100'000 * 100;
        EXPECT_GE(static_cast<double>(histogram.at(share).count()), exact);
        EXPECT_LE(static_cast<double>(histogram.at(share).count()), exact * (1 + 1.0 / 64) + 1);
    }
    EXPECT_EQ(histogram.at(1), 10ms);
    EXPECT_EQ(histogram.max(), 10ms);
}

TEST(LatencyHistogram, TheMeanIsThatOfTheSamples) {
    LatencyHistogram histogram;
    for (const Duration latency : {1'001ns, 1'002ns, 1'000'000ns}) histogram.add(latency);
    EXPECT_EQ(histogram.mean(), 334'001ns);
}

TEST(LatencyHistogram, SmallAndHugeLatenciesHaveAPlace) {
    LatencyHistogram histogram;
    histogram.add(0ns);
    histogram.add(1ns);
    histogram.add(Duration::max());
    EXPECT_EQ(histogram.at(0.3), 0ns);
    EXPECT_EQ(histogram.at(0.6), 1ns);
    EXPECT_EQ(histogram.at(1), Duration::max());
    EXPECT_EQ(histogram.count(), 3U);
}

TEST(LatencyHistogram, WithoutSamplesEverythingIsZero) {
    EXPECT_EQ(LatencyHistogram{}.at(0.99), 0ns);
    EXPECT_EQ(LatencyHistogram{}.mean(), 0ns);
}

}  // namespace
}  // namespace romano::experiments::latency_histogram_test
