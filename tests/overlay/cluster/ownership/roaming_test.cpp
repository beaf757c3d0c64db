// A client of a peer that talks to us: how long it is waited for.

#include "overlay/cluster/ownership/roaming.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "romano/mqttsn/codec.h"
#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::roaming_test {
namespace {

using namespace two_brokers;

constexpr Duration patience = 100ms;  // as in test::times

/// "robot" was at home at the peer, of which nothing was heard since, and pings us.
struct RoamingTest : testing::Test, Owner {
    RoamingTest() {
        robot.header.client_id = "robot";
        robot.header.address.endpoint = from;
        homes.on_event(peer.broker, broker::SessionPut{robot});
        std::vector<std::uint8_t> ping(8);
        ping.resize(mqttsn::encode(mqttsn::Pingreq{}, ping));
        Effects acting = effects();
        EXPECT_TRUE(
            roaming.on_datagram(acting, {ours, from}, ping, homes, departures, membership, view));
    }
    [[nodiscard]] bool is_waited_for_after(Duration time) {
        now += time;
        Effects acting = effects();
        roaming.carry_on(acting, {logs, own}, homes, arriving, departures, membership, view);
        return roaming.is_fetching({ours, from});
    }

    const Endpoint from = test::address(99);
    broker::SessionImage robot = image(0, theirs);
    Homes homes;
    PeerLogs logs;
    OwnLog own{self, 100};
    Membership membership{ClusterOptions{}, self.broker, 1};
    View view{.members = {self}};
    Arrivals arriving{self, 256};
    Departures departures{256};
    Roaming roaming{0};
};

TEST_F(RoamingTest, IsAStrangerWhenItsHomeDoesNotAnswer) {
    EXPECT_TRUE(is_waited_for_after(2 * patience));
    EXPECT_FALSE(is_waited_for_after(1ms));
}

TEST_F(RoamingTest, P2_IsNoStrangerWhileItsSessionWaitsToBeAdopted) {
    robot.worked_through = {{test::log_of("former"), 5}};
    PeerLog& home = logs.try_emplace(peer, peer, 100).first->second;
    home.offer(1, {broker::SessionPut{robot}, broker::SessionMoved{robot.header, self}});
    home.apply();
    home.apply();
    arriving.on_event(effects(), home, broker::SessionMoved{robot.header, self});
    EXPECT_TRUE(is_waited_for_after(2 * patience + 1ms));
    arriving.heed(now, [](const LogPosition&) { return true; });
    Effects acting = effects();
    arriving.on_turn();
    (void)arriving.carry_on(
        acting, {logs, own}, [](const auto&) { return std::nullopt; }, departures);
    EXPECT_FALSE(is_waited_for_after(1ms));
    EXPECT_NE(broker.header("robot"), nullptr);
}

TEST_F(RoamingTest, P2_TimeInWhichWeStoodStillDoesNotCount) {
    now += 2 * patience;
    roaming.on_standstill(now);
    EXPECT_TRUE(is_waited_for_after(2 * patience));
    EXPECT_FALSE(is_waited_for_after(1ms));
}

/// The own copy goes to a third broker, and has not arrived there.
Seq send_away(RoamingTest& test) {
    (void)test.broker.adopt(test.now, test.robot, {}, test.clients);
    Effects acting = test.effects();
    test.departures.move(acting, "robot", test::log_of("third"), 1, test.logs);
    return test.departures.all().at("robot").session.at;
}

// What its silent home had would come beside that.
TEST_F(RoamingTest, I7_AnotherCopyIsNotAdoptedWhileTheOwnIsOnItsWay) {
    PeerLog& home = logs.try_emplace(peer, peer, 100).first->second;
    home.offer(1, {broker::SessionPut{robot}});
    home.apply();
    const Seq at = send_away(*this);
    EXPECT_TRUE(is_waited_for_after(2 * patience + 1ms));
    EXPECT_EQ(broker.header("robot"), nullptr);
    departures.on_arrived("robot", at);
    EXPECT_FALSE(is_waited_for_after(1ms));
    EXPECT_NE(broker.header("robot"), nullptr) << "the third broker's log does not say so";
}

TEST_F(RoamingTest, I7_WhoConnectsFromElsewhereWaitsForTheSessionThatIsOnItsWay) {
    homes.forget(peer.broker, "robot");
    send_away(*this);
    std::vector<std::uint8_t> connect(40);
    connect.resize(
        mqttsn::encode(mqttsn::Connect{false, false, mqttsn::protocol_id, 60, "robot"}, connect));
    Effects acting = effects();
    EXPECT_TRUE(roaming.on_datagram(acting, {ours, test::address(98)}, connect, homes, departures,
                                    membership, view));
}

// What is asked of a home while it listens after a stall is not heard.
TEST_F(RoamingTest, P2_ItsHomeIsAskedAgain) {
    membership.on_beacon(now, Beacon{.log = peer, .tick = 1, .hears = {self.broker}});
    view.members = {std::min(self, peer), std::max(self, peer)};
    const auto asked_after = [this](Duration time) {
        EXPECT_TRUE(is_waited_for_after(time));
        return take_sent<SessionRequest>().size();
    };
    EXPECT_EQ(asked_after(1ms), 1U);
    EXPECT_EQ(asked_after(patience / 2 - 1ms), 0U);
    EXPECT_EQ(asked_after(1ms), 1U);
}

TEST_F(RoamingTest, P1_IsNoStrangerWhileItsHomeLivesAndIsLate) {
    membership.on_beacon(now, Beacon{.log = peer, .tick = 1, .hears = {self.broker}});
    view.members = {std::min(self, peer), std::max(self, peer)};
    EXPECT_TRUE(is_waited_for_after(1ms)) << "it is asked";
    EXPECT_TRUE(is_waited_for_after(3 * patience));
    EXPECT_FALSE(is_waited_for_after(test::times.living_home_waited_for())) << "it has no answer";
}

// It may hear us, though we do not hear it, and gives the session away before we take our copy.
TEST_F(RoamingTest, I7_AHomeThatCannotAnswerIsAskedAsWell) {
    membership.on_beacon(now, Beacon{.log = peer, .tick = 1});
    ASSERT_FALSE(membership.is_alive(peer));
    view.members = {std::min(self, peer), std::max(self, peer)};
    PeerLog& home = logs.try_emplace(peer, peer, 100).first->second;
    home.offer(1, {broker::SessionPut{robot}});
    home.apply();
    const auto asked_after = [this](Duration time) {
        EXPECT_TRUE(is_waited_for_after(time));
        return take_sent<SessionRequest>().size();
    };
    EXPECT_EQ(asked_after(1ms), 1U);
    EXPECT_EQ(asked_after(patience / 2 - 1ms), 0U);
    EXPECT_EQ(asked_after(1ms), 1U);
    EXPECT_FALSE(is_waited_for_after(2 * patience - patience / 2)) << "no longer than who is lost";
    EXPECT_NE(broker.header("robot"), nullptr);
}

// Its last word to us comes a moment after the new home has asked for its session.
TEST(RoamingAway, P2_IsNoStrangerToTheHomeThatJustLetItGo) {
    Cluster cluster;
    cluster.serve(ours);
    cluster.hear();
    const Endpoint from = test::address(99);
    const auto octets = [](const auto& message) {
        std::vector<std::uint8_t> datagram(64);
        datagram.resize(mqttsn::encode(message, datagram));
        return datagram;
    };
    const mqttsn::Connect connect{false, true, mqttsn::protocol_id, 60, "robot"};
    cluster.broker.on_datagram(cluster.now, ours, from, octets(connect), cluster.clients);
    cluster.keep_log();
    ASSERT_NE(cluster.broker.header("robot"), nullptr);
    cluster.take(SessionRequest{"robot", theirs});
    ASSERT_EQ(cluster.broker.header("robot"), nullptr);
    Effects acting = cluster.effects();
    EXPECT_TRUE(cluster.core.must_fetch(acting, ours, from, octets(mqttsn::Pingreq{})));
}

TEST_F(RoamingTest, ANodeBehindAForwarderIsItsOwnClient) {
    robot.header.client_id = "node";
    robot.header.address.wireless_node_id = "7";
    homes.on_event(peer.broker, broker::SessionPut{robot});
    const auto asks_for = [&](std::string_view node, const auto& message) {
        std::vector<std::uint8_t> inner(40);
        inner.resize(mqttsn::encode(message, inner));
        std::vector<std::uint8_t> wrapped(60);
        wrapped.resize(mqttsn::encode(mqttsn::Encapsulated{0, as_octets(node), inner}, wrapped));
        Effects acting = effects();
        return roaming.on_datagram(acting, {ours, from}, wrapped, homes, departures, membership,
                                   view);
    };
    EXPECT_TRUE(asks_for("7", mqttsn::Pingreq{""}));
    EXPECT_FALSE(asks_for("8", mqttsn::Pingreq{""}));
    EXPECT_TRUE(asks_for("8", mqttsn::Connect{false, false, mqttsn::protocol_id, 60, "node"}));
    EXPECT_FALSE(asks_for("8", mqttsn::Searchgw{1}));
}

}  // namespace
}  // namespace romano::cluster::roaming_test
