#include "election/link.h"

#include <gmock/gmock.h>

namespace romano::election::link_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr NodeId a{1};

struct Watched {
    LinkDetector detector{{.beacon_every = 10ms, .timeout = 50ms}};
    Instant now{};

    void beacons(int count) {
        for (int i = 0; i < count; ++i) {
            now += 10ms;
            detector.on_beacon(now, a);
            detector.on_tick(now);
        }
    }
};

TEST(LinkDetector, ALostLinkIsSuspectedAtOnce) {
    Watched watched;
    watched.beacons(1);
    watched.detector.on_link(watched.now, a, Link::lost);
    EXPECT_FALSE(watched.detector.is_alive(a));
    EXPECT_THAT(watched.detector.take_suspects(), ElementsAre(a));
}

TEST(LinkDetector, SilenceIsLeftToTheBeacons) {
    Watched watched;
    watched.beacons(1);
    watched.detector.on_link(watched.now, a, Link::up);
    for (int missed = 1; missed < 5; ++missed) {  // the tick of that beacon counts
        EXPECT_TRUE(watched.detector.is_alive(a));
        watched.now += 10ms;
        watched.detector.on_tick(watched.now);
    }
    EXPECT_FALSE(watched.detector.is_alive(a));
}

TEST(LinkDetector, TheLastBeaconsOfADeadNodeDoNotRaiseIt) {
    Watched watched;
    watched.beacons(1);
    watched.detector.on_link(watched.now, a, Link::lost);
    watched.beacons(3);
    EXPECT_FALSE(watched.detector.is_alive(a));
}

TEST(LinkDetector, BeaconsThatGoOnDisproveTheLoss) {
    Watched watched;
    watched.beacons(1);
    watched.detector.on_link(watched.now, a, Link::lost);
    watched.beacons(4);
    EXPECT_TRUE(watched.detector.is_alive(a));
}

TEST(LinkDetector, ALinkThatIsUpAgainDisprovesTheLoss) {
    Watched watched;
    watched.beacons(1);
    watched.detector.on_link(watched.now, a, Link::lost);
    watched.detector.on_link(watched.now, a, Link::up);
    watched.beacons(1);
    EXPECT_TRUE(watched.detector.is_alive(a));
}

TEST(LinkDetector, ARestartedNodeIsBelievedAtItsFirstBeacon) {
    Watched watched;
    watched.beacons(1);
    watched.detector.on_link(watched.now, a, Link::lost);
    watched.detector.on_restart(a);
    watched.beacons(1);
    EXPECT_TRUE(watched.detector.is_alive(a));
}

TEST(LinkDetector, ANodeThatWasNeverHeardIsNotSuspected) {
    Watched watched;
    watched.detector.on_link(watched.now, a, Link::lost);
    EXPECT_THAT(watched.detector.take_suspects(), IsEmpty());
}

}  // namespace
}  // namespace romano::election::link_test
