#include "broker/daemon/standstill.h"

#include <gmock/gmock.h>

#include <string>

#include "tests/broker/daemon/captured_trace.h"

namespace romano::daemon::standstill_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::IsEmpty;

class SayingOfStandstills : public testing::Test {
protected:
    SayingOfStandstills() { standstill_.look(now_, Instant::min(), worked_); }

    /// What is said at a wake-up that was due after `due`, and comes `late` after that.
    std::string after(Duration due, Duration late, Duration work) {
        trace_.clear();
        const Instant due_at = now_ + due;
        now_ = due_at + late;
        worked_ += work;
        standstill_.look(now_, due_at, worked_);
        return trace_.text();
    }
    /// At a wake-up that was due at once.
    std::string at_once_after(Duration time) {
        trace_.clear();
        now_ += time;
        standstill_.look(now_, Instant::min(), worked_);
        return trace_.text();
    }

private:
    CapturedTrace trace_;
    Standstill standstill_{50ms};
    Instant now_{100s};
    Duration worked_ = 3s;
};

TEST_F(SayingOfStandstills, HalfOfTheDetectionTimeoutIsSaidAndWhatItWentFor) {
    EXPECT_THAT(after(10ms, 24ms, 24ms), IsEmpty());
    EXPECT_THAT(after(10ms, 31ms, 2ms), HasSubstr("stood still for 31 ms, 2 ms of them at work"));
}

TEST_F(SayingOfStandstills, WorkBeforeTheWakeUpWasDueIsNoStandstill) {
    EXPECT_THAT(after(100ms, 5ms, 105ms), IsEmpty());
    EXPECT_THAT(after(10ms, 40ms, 50ms), HasSubstr("for 40 ms, 40 ms of them"));
}

TEST_F(SayingOfStandstills, WhatIsDueAtOnceIsLateSinceTheLastWakeUp) {
    EXPECT_THAT(at_once_after(24ms), IsEmpty());
    EXPECT_THAT(at_once_after(26ms), HasSubstr("stood still for 26 ms"));
}

TEST_F(SayingOfStandstills, AStarvedBrokerDoesNotFillTheTrace) {
    EXPECT_THAT(after(10ms, 40ms, 0ms), HasSubstr("stood still"));
    EXPECT_THAT(after(900ms, 99ms, 0ms), IsEmpty());
    EXPECT_THAT(after(10ms, 40ms, 0ms), HasSubstr("stood still"));
}

TEST(ThreadProcessorTime, GrowsWithWork) {
    const Duration before = thread_processor_time();
    while (thread_processor_time() < before + 1ms) {
    }
    EXPECT_GE(thread_processor_time(), before + 1ms);
}

}  // namespace
}  // namespace romano::daemon::standstill_test
