#include "broker/daemon/standstill.h"

#include <gmock/gmock.h>

#include <string>

#include "tests/broker/daemon/captured_trace.h"

namespace romano::daemon {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::IsEmpty;

class SayingOfStandstills : public testing::Test {
protected:
    SayingOfStandstills() { standstill_.look(now_, worked_); }

    /// What is said after that time, and that much work in it.
    std::string after(Duration time, Duration work) {
        trace_.clear();
        now_ += time;
        worked_ += work;
        standstill_.look(now_, worked_);
        return trace_.text();
    }

private:
    CapturedTrace trace_;
    Standstill standstill_{50ms};
    Instant now_{100s};
    Duration worked_ = 3s;
};

TEST_F(SayingOfStandstills, HalfOfTheDetectionTimeoutIsSaidAndWhatItWentFor) {
    EXPECT_THAT(after(24ms, 24ms), IsEmpty());
    EXPECT_THAT(after(31ms, 2ms), HasSubstr("stood still for 31 ms, 2 ms of them at work"));
}

TEST_F(SayingOfStandstills, AStarvedBrokerDoesNotFillTheTrace) {
    EXPECT_THAT(after(40ms, 0ms), HasSubstr("stood still"));
    EXPECT_THAT(after(999ms, 0ms), IsEmpty());
    EXPECT_THAT(after(40ms, 0ms), HasSubstr("stood still"));
}

TEST(ThreadProcessorTime, GrowsWithWork) {
    const Duration before = thread_processor_time();
    while (thread_processor_time() < before + 1ms) {
    }
    EXPECT_GE(thread_processor_time(), before + 1ms);
}

}  // namespace
}  // namespace romano::daemon
