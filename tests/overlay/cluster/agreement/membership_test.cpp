#include "overlay/cluster/agreement/membership.h"

#include <gmock/gmock.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::membership_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

const LogId self = test::log_of("self");
const LogId peer = test::log_of("peer");

struct Observer {
    explicit Observer(const ClusterOptions& options = {}) : membership{options, self.broker, 1} {}

    Membership membership;
    Instant now{1s};
    std::uint64_t ticks = 0;

    bool hear(std::vector<BrokerId> hears, const LogId& log = peer, bool leaving = false) {
        Beacon beacon{.log = log, .tick = ++ticks, .hears = std::move(hears)};
        beacon.leaving = leaving;
        return membership.on_beacon(now, beacon) != Membership::Heard::nothing;
    }
    void pulse(std::uint64_t tick, const LogId& log = peer) {
        membership.on_pulse(now, {.log = log, .tick = tick});
    }
    void wait(Duration time) {
        for (const Instant end = now + time; now < end;) {
            now += 10ms;
            membership.on_tick(now);
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

// I1: the lease of its next life counts, also before that hears us.
TEST(Membership, WhoSaidGoodbyeAndCameBackHasNotEnded) {
    Observer observer;
    observer.hear({self.broker}, peer, true);
    EXPECT_TRUE(observer.membership.has_ended(peer));
    const LogId next_life{peer.broker, peer.incarnation + 1};
    observer.hear({}, next_life);
    EXPECT_TRUE(observer.membership.has_ended(peer));
    EXPECT_FALSE(observer.membership.has_ended(next_life));
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

TEST(Membership, ARaftLeaderIsNotKnownByItsProposals) {  // P1: their number may be beyond its term
    ClusterOptions options;
    options.elector = "raft";
    Membership membership{options, self.broker, 1};
    Beacon beacon{.log = peer, .tick = 1, .hears = {self.broker}};
    beacon.claim = {.rank = {.id = node_of(peer.broker)}, .term = 1, .leader = {}};
    membership.on_beacon(Instant{1s}, beacon);
    membership.on_leader(Instant{1s}, peer.broker, 2);
    EXPECT_EQ(membership.leadership(), (election::Leadership{1, std::nullopt}));
}

TEST(Membership, SilenceEndsALife) {
    Observer observer;
    observer.hear({self.broker});
    observer.wait(90ms);
    EXPECT_TRUE(observer.membership.is_alive(peer));
    observer.wait(20ms);
    EXPECT_FALSE(observer.membership.is_alive(peer));
}

TEST(Membership, APulseIsASignOfLife) {
    Observer observer;
    observer.hear({self.broker});
    observer.wait(90ms);
    observer.pulse(observer.ticks);
    observer.wait(90ms);
    EXPECT_TRUE(observer.membership.is_alive(peer));
    EXPECT_TRUE(observer.membership.is_heard(peer.broker));
    observer.wait(20ms);
    EXPECT_FALSE(observer.membership.is_alive(peer));
}

TEST(Membership, APulseRaisesNobodyFromTheDead) {  // only a beacon says whom it hears now
    Observer observer;
    observer.pulse(1);
    EXPECT_FALSE(observer.membership.is_heard(peer.broker)) << "never met";
    observer.hear({self.broker});
    observer.wait(200ms);
    observer.pulse(observer.ticks);
    EXPECT_FALSE(observer.membership.is_alive(peer));
    EXPECT_FALSE(observer.membership.is_heard(peer.broker));
}

TEST(Membership, APulseFromBeforeTheLastBeaconOrOfAnotherLifeSaysNothing) {
    Observer observer;
    observer.hear({self.broker});
    observer.hear({self.broker});
    observer.wait(90ms);
    observer.pulse(observer.ticks - 1);
    observer.pulse(observer.ticks, {peer.broker, peer.incarnation + 1});
    observer.wait(20ms);
    EXPECT_FALSE(observer.membership.is_alive(peer));
}

TEST(Membership, APulseOfWhoDoesNotHearUsIsNoLink) {
    Observer observer;
    observer.hear({self.broker});
    for (int i = 0; i < 20; ++i) {
        observer.hear({});
        observer.pulse(observer.ticks);
        observer.wait(10ms);
    }
    EXPECT_FALSE(observer.membership.is_alive(peer));
    EXPECT_TRUE(observer.membership.is_heard(peer.broker));
}

TEST(Membership, WhoWasLeftOutOfAViewIsGoneUntilItsNextBeacon) {
    Observer observer;
    observer.hear({self.broker});
    observer.wait(60ms);
    observer.membership.on_left_out(observer.now, peer);
    EXPECT_FALSE(observer.membership.is_alive(peer));
    EXPECT_FALSE(observer.membership.is_heard(peer.broker));
    observer.hear({self.broker});
    EXPECT_TRUE(observer.membership.is_alive(peer));
    EXPECT_TRUE(observer.membership.is_heard(peer.broker));
}

TEST(Membership, WhoWasLeftOutOfAViewAndSpokeJustNowIsHeard) {  // by us, if not by the leader
    Observer observer;
    observer.hear({self.broker});
    observer.wait(20ms);
    observer.membership.on_left_out(observer.now, peer);
    EXPECT_FALSE(observer.membership.is_alive(peer));
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

struct LinkedObserver : Observer {
    LinkedObserver() : Observer{with_links()} { hear_linked(); }

    static ClusterOptions with_links() {
        ClusterOptions options;
        options.detector = "link";
        return options;
    }
    void hear_linked(const LogId& log = peer, std::uint64_t process = peer.incarnation) {
        Beacon beacon{.log = log, .tick = ++ticks, .hears = {self.broker}};
        beacon.link.process = process;
        (void)membership.on_beacon(now, beacon);
    }
};

TEST(Membership, ALostLinkEndsALifeAtOnce) {
    LinkedObserver observer;
    EXPECT_TRUE(observer.membership.on_link(observer.now, peer, election::Link::lost));
    EXPECT_FALSE(observer.membership.is_alive(peer));
    EXPECT_THAT(observer.membership.take_lost(), ElementsAre(peer.broker));
}

TEST(Membership, TheLinkOfAnEarlierProcessSaysNothingAboutThisOne) {
    LinkedObserver observer;
    const LogId restarted{peer.broker, peer.incarnation + 1};
    observer.hear_linked(restarted, restarted.incarnation);
    EXPECT_FALSE(observer.membership.on_link(observer.now, peer, election::Link::lost));
    EXPECT_TRUE(observer.membership.is_alive(restarted));
}

TEST(Membership, AMemberThatBeganANewLogKeepsItsLink) {
    LinkedObserver observer;
    const LogId new_log{peer.broker, peer.incarnation + 1};
    observer.hear_linked(new_log, peer.incarnation);
    EXPECT_TRUE(observer.membership.on_link(observer.now, peer, election::Link::lost));
    EXPECT_FALSE(observer.membership.is_alive(new_log));
}

TEST(Membership, ARestartedPeerIsBelievedAtOnceAfterALostLink) {
    LinkedObserver observer;
    observer.membership.on_link(observer.now, peer, election::Link::lost);
    observer.hear_linked();
    EXPECT_FALSE(observer.membership.is_alive(peer)) << "a beacon that was on its way";
    const LogId restarted{peer.broker, peer.incarnation + 1};
    observer.hear_linked(restarted, restarted.incarnation);
    EXPECT_TRUE(observer.membership.is_alive(restarted));
}

}  // namespace
}  // namespace romano::cluster::membership_test
