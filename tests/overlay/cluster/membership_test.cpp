#include "overlay/cluster/membership.h"

#include <gmock/gmock.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

const LogId self = test::log_of("self");
const LogId peer = test::log_of("peer");

struct Observer {
    Membership membership{ClusterOptions{}, self.broker, 1};
    Outbox out;
    Instant now{1s};
    std::uint64_t ticks = 0;

    bool hear(std::vector<BrokerId> hears, const LogId& log = peer, bool leaving = false) {
        Beacon beacon{.log = log, .tick = ++ticks, .hears = std::move(hears)};
        beacon.leaving = leaving;
        return membership.on_beacon(now, beacon);
    }
    void wait(Duration time) {
        for (const Instant end = now + time; now < end;) {
            now += 10ms;
            membership.on_tick(now, out);
        }
    }
};

TEST(Membership, ALinkThatWorksOneWayIsNone) {
    Observer observer;
    observer.hear({});
    EXPECT_TRUE(observer.membership.is_heard(peer.broker));
    EXPECT_FALSE(observer.membership.is_alive(peer));
    observer.hear({self.broker});
    EXPECT_TRUE(observer.membership.is_alive(peer));
}

TEST(Membership, APeerThatHearsUsNoMoreIsSuspected) {
    Observer observer;
    observer.hear({self.broker});
    for (int i = 0; i < 20; ++i) {
        observer.hear({});
        observer.wait(10ms);
    }
    EXPECT_FALSE(observer.membership.is_alive(peer));
    EXPECT_TRUE(observer.membership.is_heard(peer.broker));
}

TEST(Membership, SilenceEndsALife) {
    Observer observer;
    observer.hear({self.broker});
    observer.wait(90ms);
    EXPECT_TRUE(observer.membership.is_alive(peer));
    observer.wait(20ms);
    EXPECT_FALSE(observer.membership.is_alive(peer));
}

TEST(Membership, WhoWasLeftOutOfAViewIsGoneUntilItsNextBeacon) {
    Observer observer;
    observer.hear({self.broker});
    observer.membership.on_left_out(observer.now, peer);
    EXPECT_FALSE(observer.membership.is_alive(peer));
    EXPECT_FALSE(observer.membership.is_heard(peer.broker));
    observer.hear({self.broker});
    EXPECT_TRUE(observer.membership.is_alive(peer));
    EXPECT_TRUE(observer.membership.is_heard(peer.broker));
}

TEST(Membership, TheLastBeaconOfAnOrderlyStopEndsItAtOnce) {
    Observer observer;
    observer.hear({self.broker});
    observer.hear({self.broker}, peer, true);
    EXPECT_FALSE(observer.membership.is_alive(peer));
}

TEST(Membership, AnEarlierLifeIsNotListenedTo) {
    Observer observer;
    const LogId second{peer.broker, 2};
    EXPECT_TRUE(observer.hear({self.broker}, second));
    EXPECT_FALSE(observer.hear({self.broker}, peer));
    EXPECT_TRUE(observer.membership.is_alive(second));
    EXPECT_FALSE(observer.membership.is_alive(peer));
}

TEST(Membership, TheOwnBeaconSaysWhomItHears) {
    Observer observer;
    observer.hear({});
    Beacon own;
    observer.membership.describe(own);
    EXPECT_THAT(own.hears, ElementsAre(peer.broker));
    observer.wait(200ms);
    Beacon later;
    observer.membership.describe(later);
    EXPECT_THAT(later.hears, IsEmpty());
}

}  // namespace
}  // namespace romano::cluster
