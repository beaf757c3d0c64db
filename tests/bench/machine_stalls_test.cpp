#include "bench/machine_stalls.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace romano::bench::machine_stalls_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

TEST(LateWakeUps, CountOnlyWhatABusyKernelDoesNotDo) {
    LateWakeUps late;
    late.on_wake_up(60us);
    late.on_wake_up(3999us);
    EXPECT_EQ(late.count(), 0U);
    EXPECT_EQ(late.longest(), Duration{});
    late.on_wake_up(16ms);
    late.on_wake_up(4ms);
    EXPECT_EQ(late.count(), 2U);
    EXPECT_EQ(late.longest(), 16ms);
}

TEST(MachineStalls, SayWhatWasSeenAndWhatCannotBe) {
    EXPECT_THAT(text_of(std::nullopt), HasSubstr("is not known"));
    EXPECT_THAT(text_of(MachineStalls::Seen{}), HasSubstr("never stood still"));
    EXPECT_THAT(text_of(MachineStalls::Seen{.count = 3, .longest = 16'100us}),
                HasSubstr("3 times for 4 ms or longer meanwhile, for 16.1 ms at most"));
}

/// Whether or not this user may look: the threads end with what they belong to.
TEST(MachineStalls, AreLookedForOnlyAsLongAsSomebodyWantsThem) {
    for (int i = 0; i < 3; ++i) {
        const MachineStalls stalls;
        const MachineStalls::Seen seen = stalls.seen().value_or(MachineStalls::Seen{});
        EXPECT_TRUE(seen.count == 0 || seen.longest >= LateWakeUps::counted_from);
    }
}

}  // namespace
}  // namespace romano::bench::machine_stalls_test
