#include "broker/daemon/processor_load.h"

#include <gtest/gtest.h>

#include <chrono>

namespace romano::daemon::processor_load_test {
namespace {

using namespace std::chrono_literals;

constexpr Instant start{1h};

TEST(ProcessorLoad, IsTheShareOfACoreInTheLastFiveSeconds) {
    ProcessorLoad load;
    EXPECT_EQ(load.percent(), 0U);
    load.on_reading(start, 10s);  // before anybody looked
    EXPECT_EQ(load.percent(), 0U);
    load.on_reading(start + 1s, 10s + 250ms);
    EXPECT_EQ(load.percent(), 25U);
    Duration used = 10s + 250ms;
    for (int second = 2; second <= 20; ++second) load.on_reading(start + second * 1s, used += 40ms);
    EXPECT_EQ(load.percent(), 4U) << "what was longer ago does not count";
}

TEST(ProcessorLoad, OfSeveralThreadsIsMoreThanACore) {
    ProcessorLoad load;
    load.on_reading(start, 0s);
    load.on_reading(start + 2s, 3s);
    EXPECT_EQ(load.percent(), 150U);
}

TEST(ProcessorLoad, IsNotReadMoreOftenThanEachHalfSecond) {
    ProcessorLoad load;
    load.on_reading(start, 0s);
    load.on_reading(start + 1s, 100ms);
    load.on_reading(start + 1s + 1ms, 10s);
    EXPECT_EQ(load.percent(), 10U);
}

TEST(ProcessorLoad, TheProcesssTimeGrowsAsItWorks) {
    const Duration before = process_processor_time();
    while (process_processor_time() < before + 1ms) {
    }
    EXPECT_GE(process_processor_time(), before + 1ms);
}

}  // namespace
}  // namespace romano::daemon::processor_load_test
