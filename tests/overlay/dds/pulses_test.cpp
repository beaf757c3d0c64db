#include "overlay/pulses.h"

#include <gmock/gmock.h>

#include <vector>

namespace romano::overlay::pulses_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

struct Rhythm : testing::Test {
    /// When pulses are sent from then on, as counts of milliseconds, by somebody who looks at each.
    std::vector<std::int64_t> pulses_until(Instant end) {
        std::vector<std::int64_t> sent;
        for (; now < end; now += 1ms) {
            if (pulses.take_due(now)) sent.push_back(now.time_since_epoch() / 1ms);
        }
        return sent;
    }

    Pulses pulses{10ms, 60ms};
    Instant now{};
};

TEST_F(Rhythm, NobodyPulsesBeforeTheFirstBeacon) {
    EXPECT_EQ(pulses.next(), never);
    EXPECT_THAT(pulses_until(Instant{1s}), IsEmpty());
}

TEST_F(Rhythm, NobodyPulsesForACoreThatIsInTime) {
    for (int beacon = 0; beacon < 10; ++beacon) {
        pulses.on_beacon(now);
        EXPECT_THAT(pulses_until(now + 14ms), IsEmpty());
    }
}

TEST_F(Rhythm, ALateCoreIsGoneOnForHalfADetectionTime) {
    pulses.on_beacon(now);
    EXPECT_THAT(pulses_until(Instant{1s}), ElementsAre(15, 25, 35));
    EXPECT_EQ(pulses.next(), never);
}

TEST_F(Rhythm, TheNextBeaconBeginsAnew) {
    pulses.on_beacon(now);
    EXPECT_THAT(pulses_until(Instant{30ms}), ElementsAre(15, 25));
    pulses.on_beacon(now);
    EXPECT_THAT(pulses_until(Instant{1s}), ElementsAre(45, 55, 65));
}

TEST_F(Rhythm, AProcessThatStoodStillAltogetherDoesNotPulseForThatTime) {
    pulses.on_beacon(now);
    EXPECT_FALSE(pulses.take_due(Instant{41ms}));
    EXPECT_EQ(pulses.next(), never);
}

TEST_F(Rhythm, NothingFollowsTheLastBeacon) {
    pulses.on_beacon(now);
    pulses.end();
    EXPECT_THAT(pulses_until(Instant{1s}), IsEmpty());
}

}  // namespace
}  // namespace romano::overlay::pulses_test
