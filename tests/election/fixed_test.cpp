#include "election/fixed.h"

#include <gmock/gmock.h>

namespace romano::election::fixed_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr NodeId a{1};
constexpr NodeId b{2};

struct Clocked {
    FixedDetector detector{{.beacon_every = 10ms, .timeout = 50ms}};
    Instant now{};

    void tick(int times) {
        for (int i = 0; i < times; ++i) {
            now += 10ms;
            detector.on_tick(now);
        }
    }
};

TEST(FixedDetector, SilenceOfTheTimeoutIsSuspectedOnce) {
    Clocked clock;
    clock.detector.on_beacon(clock.now, a);
    clock.tick(4);
    EXPECT_TRUE(clock.detector.is_alive(a));
    EXPECT_THAT(clock.detector.take_suspects(), IsEmpty());
    clock.tick(1);
    EXPECT_FALSE(clock.detector.is_alive(a));
    EXPECT_THAT(clock.detector.take_suspects(), ElementsAre(a));
    clock.tick(10);
    EXPECT_THAT(clock.detector.take_suspects(), IsEmpty());
}

TEST(FixedDetector, BeaconsKeepAlive) {
    Clocked clock;
    for (int i = 0; i < 100; ++i) {
        clock.detector.on_beacon(clock.now, a);
        clock.tick(4);
    }
    EXPECT_TRUE(clock.detector.is_alive(a));
}

TEST(FixedDetector, AStallOfTheObserverIsNotBlamedOnItsPeers) {
    Clocked clock;
    clock.detector.on_beacon(clock.now, a);
    clock.now += 10s;
    clock.detector.on_tick(clock.now);
    EXPECT_TRUE(clock.detector.is_alive(a));
}

TEST(FixedDetector, RepeatedTicksCountOnce) {
    Clocked clock;
    clock.detector.on_beacon(clock.now, a);
    clock.tick(1);
    for (int i = 0; i < 100; ++i) clock.detector.on_tick(clock.now);
    EXPECT_TRUE(clock.detector.is_alive(a));
}

TEST(FixedDetector, GoodbyeIsSuspicionAtOnce) {
    Clocked clock;
    clock.detector.on_beacon(clock.now, a);
    clock.detector.on_beacon(clock.now, b);
    clock.detector.on_gone(clock.now, a);
    EXPECT_THAT(clock.detector.take_suspects(), ElementsAre(a));
    EXPECT_TRUE(clock.detector.is_alive(b));
}

TEST(FixedDetector, ABeaconOfASuspectBringsItBack) {
    Clocked clock;
    clock.detector.on_beacon(clock.now, a);
    clock.tick(5);
    clock.detector.on_beacon(clock.now, a);
    EXPECT_TRUE(clock.detector.is_alive(a));
    EXPECT_THAT(clock.detector.take_suspects(), IsEmpty());
}

TEST(FixedDetector, AnUnknownNodeIsNotAlive) {
    Clocked clock;
    EXPECT_FALSE(clock.detector.is_alive(a));
}

}  // namespace
}  // namespace romano::election::fixed_test
