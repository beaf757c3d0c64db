// A newcomer whom a view takes in has met the leader, and the other members perhaps not yet. When
// the leader dies then, those may be about to go on without it.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::stranded_test {
namespace {

using namespace two_brokers;

const LogId other = test::log_of("other");

/// In a view with the peer, which leads it and is gone now, and with one that it never met.
class Stranded : public testing::Test {
protected:
    Stranded() {
        Beacon leads{.name = "peer", .log = peer, .tick = 1, .hears = {self.broker}};
        leads.claim = {.rank = {.capability = 9, .id = node_of(peer.broker)},
                       .term = 5,
                       .leader = node_of(peer.broker)};
        cluster.take(leads);
        View view{.number = {.term = 5, .leader = peer.broker, .count = 1},
                  .members = {self, peer, other}};
        std::ranges::sort(view.members);
        cluster.take(ViewAnnouncement{.view = view, .assignments = {}, .ends = {}});
        broker::SessionImage image =
            std::get<broker::SessionPut>(test::session("robot", ours)).image;
        image.header.address.endpoint = robot;
        (void)cluster.broker.adopt(cluster.now, std::move(image), {}, cluster.clients);
        cluster.keep_log();
        EXPECT_TRUE(cluster.core.view().contains(other));
    }
    /// Its beacons come here, and ours do not reach it.
    void hear_the_other_for(Duration time) {
        for (const Instant end = cluster.now + time; cluster.now < end;) {
            Effects acting = cluster.effects();
            hear(cluster.core, acting, Beacon{.log = other, .tick = ++other_ticks});
            cluster.pass();
        }
    }
    void hear_nothing_for(Duration time) {
        for (const Instant end = cluster.now + time; cluster.now < end;) cluster.pass();
    }

    const Endpoint robot = test::address(7);
    Cluster cluster;
    std::uint64_t other_ticks = 0;
};

// That one may be home to them: to answer as to strangers would cost them their sessions
// (simulator, seed 3125713).
TEST_F(Stranded, P1_RobotsWaitUntilANewcomerHasMetAllWhoTookItIn) {
    EXPECT_TRUE(cluster.waits_for_session(ours, robot));
    cluster.take(Beacon{.name = "other", .log = other, .tick = 1, .hears = {self.broker}});
    EXPECT_FALSE(cluster.waits_for_session(ours, robot));
}

// I1: that one may serve it, and draw no suspicion here.
TEST_F(Stranded, I1_ANewcomerTakesItsAddressOnceItHasMetAllWhoTookItIn) {
    const auto takes_its_address = [&] {
        cluster.local.clear();
        cluster.tick();
        return std::ranges::any_of(cluster.local, [](const LocalAction& action) {
            return std::holds_alternative<TakeAddress>(action);
        });
    };
    EXPECT_FALSE(takes_its_address());
    cluster.take(Beacon{.name = "other", .log = other, .tick = 1, .hears = {self.broker}});
    cluster.now += test::times.addresses_sought_every();
    EXPECT_TRUE(takes_its_address());
}

TEST_F(Stranded, P1_NobodyWaitsForAMemberThatComesLater) {
    cluster.take(Beacon{.name = "other", .log = other, .tick = 1, .hears = {self.broker}});
    View view = cluster.core.view();
    ++view.number.count;
    view.members.push_back(test::log_of("late"));
    std::ranges::sort(view.members);
    cluster.take(ViewAnnouncement{.view = view, .assignments = {}, .ends = {}});
    ASSERT_EQ(cluster.core.view().members.size(), 4U);
    EXPECT_FALSE(cluster.waits_for_session(ours, robot));
}

TEST_F(Stranded, P1_NorForOneThatWasRemovedMeanwhile) {
    View view = cluster.core.view();
    ++view.number.count;
    std::erase(view.members, other);
    cluster.take(ViewAnnouncement{.view = view, .assignments = {}, .ends = {{other, 0}}});
    ASSERT_EQ(cluster.core.view().members.size(), 2U);
    EXPECT_FALSE(cluster.waits_for_session(ours, robot));
}

// P3: the other one took the address over meanwhile (simulator, seed 1042460).
TEST_F(Stranded, ANewcomerDoesNotGoOnAloneWhileItHearsWhomItDoesNotReachYet) {
    hear_the_other_for(500ms);
    ASSERT_TRUE(cluster.core.live_peers().empty());
    EXPECT_EQ(cluster.core.view().members.size(), 3U);
    EXPECT_EQ(cluster.core.safe(cluster.now), 0U) << "nobody holds what clients would be told";
}

TEST_F(Stranded, ANewcomerGoesOnAloneWhenNobodyIsToBeHeard) {
    hear_nothing_for(500ms);
    EXPECT_EQ(cluster.core.view().members.size(), 1U);
    EXPECT_EQ(cluster.core.safe(cluster.now), 1U);
}

TEST_F(Stranded, ANewcomerWhomAMemberNeverHearsGoesOnAloneInTheEnd) {
    hear_the_other_for(3s);
    EXPECT_EQ(cluster.core.view().members.size(), 1U);
    EXPECT_EQ(cluster.core.safe(cluster.now), 1U);
}

/// A newcomer that hears the heartbeats of one who does not hear it yet, and is told no
/// particulars.
struct Unanswered : Cluster {
    void hear_heartbeats_for(Duration time) {
        for (const Instant end = now + time; now < end;) {
            const View view{.number = {.term = 5, .leader = peer.broker, .count = 1},
                            .members = {peer}};
            take(heartbeats.write(
                Beacon{.name = "peer", .log = peer, .tick = ++ticks, .view = view}));
            pass();
        }
    }
    HeartbeatWriter heartbeats;
};

// P3: another one had the sessions that it took over then (simulator, as shipped, seed 13594).
TEST(Unanswered, P3_ANewcomerOpensNoViewWhileItHearsAnUnknownBroker) {
    Unanswered newcomer;
    newcomer.hear_heartbeats_for(1s);
    EXPECT_TRUE(newcomer.core.membership().peers().empty());
    EXPECT_FALSE(newcomer.core.is_in_view());
    for (int beacons = 0; beacons < 15; ++beacons) newcomer.pass();
    EXPECT_FALSE(newcomer.core.is_in_view()) << "it may only stand still";
}

TEST(Unanswered, P1_ANewcomerServesInTheEndThoughNobodyAnswers) {
    Unanswered newcomer;
    newcomer.hear_heartbeats_for(3s);
    EXPECT_TRUE(newcomer.core.is_in_view());
}

/// A newcomer that met a broker of a view just before that one's process ended.
struct Bereaved : Cluster {
    explicit Bereaved(std::vector<LogId> members) {
        std::ranges::sort(members);
        Beacon beacon{.name = "peer",
                      .log = peer,
                      .view = {.number = {.term = 5, .leader = peer.broker, .count = 1},
                               .members = std::move(members)},
                      .hears = {self.broker}};
        beacon.claim = {.rank = {.capability = 9, .id = node_of(peer.broker)},
                        .term = 5,
                        .leader = node_of(peer.broker)};
        for (beacon.tick = 1; beacon.tick <= 3; ++beacon.tick) {
            take(beacon);
            pass();
        }
        beacon.leaving = true;
        take(beacon);
        for (int beacons = 0; beacons < 60; ++beacons) pass();
    }
};

// P3, I5: the other member goes on for the sessions, and was not heard yet.
TEST(Bereaved, I5_ANewcomerOpensNoViewBeforeItHeardWhoWasInAViewWithTheDead) {
    EXPECT_FALSE(Bereaved({peer, other}).core.is_in_view());
    EXPECT_TRUE(Bereaved({peer}).core.is_in_view()) << "nobody else is there";
}

// I3: with phi-accrual a member is suspected while the lease lasts; it may only stand still.
TEST(Suspicion, I3_NothingMoreIsSafeThoughNobodyIsLeftBeforeTheNextViewSaysSo) {
    ClusterOptions options;
    options.detector = "phi-accrual";
    Cluster broker{options};
    for (int beacons = 0; beacons < 200; ++beacons) broker.hear();
    View view{.number = {1'000, self.broker, 1}, .members = {self, peer}};
    std::ranges::sort(view.members);
    broker.take(ViewAnnouncement{.view = view, .assignments = {}, .ends = {}});
    broker.hear();
    const Seq held = broker.core.safe(broker.now);
    (void)broker.broker.adopt(broker.now, image(1, ours), {}, broker.clients);
    broker.keep_log();
    while (broker.core.membership().is_alive(peer)) {
        broker.now += 1ms;
        broker.tick();
    }
    ASSERT_TRUE(broker.core.speaking().may_speak(broker.now));
    ASSERT_EQ(broker.core.view().members.size(), 2U);
    EXPECT_EQ(broker.core.safe(broker.now), held);
}

// P3: its peers had begun new lives, it waited for nobody, and what it had promised then was more
// than those held who had gone on without it (simulator, faults `relapse`, seed 9990563).
TEST_F(Stranded, P3_WhoHasNoLeasePromisesNothing) {
    cluster.take(Beacon{.name = "other", .log = other, .tick = 1, .hears = {self.broker}});
    ASSERT_EQ(cluster.core.safe(cluster.now), 0U) << "the peers do not hold it";
    for (LogId later : {peer, other}) {
        ++later.incarnation;
        Effects acting = cluster.effects();
        hear(cluster.core, acting, Beacon{.log = later, .tick = 1});
    }
    ASSERT_TRUE(cluster.core.live_peers().empty());
    EXPECT_EQ(cluster.core.safe(cluster.now), 0U) << "no member vouches for it";
    hear_nothing_for(500ms);
    EXPECT_EQ(cluster.core.safe(cluster.now), 1U);
}

}  // namespace
}  // namespace romano::cluster::stranded_test
