#include "overlay/cluster/replication/peer_sessions.h"

#include <gtest/gtest.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::peer_sessions_test {
namespace {

const LogId peer = test::log_of("peer");
const LogId heir = test::log_of("heir");

/// "peer" is home to "robot", which subscribed to `pose`.
struct PeerSessionsTest : testing::Test {
    PeerSessionsTest() {
        sessions.reset(peer, broker::Mirror{peer});
        for (const auto& event : {test::session("robot"), test::subscribed("robot", "pose")}) {
            sessions.on_event({}, mirror, event, 10);
            mirror.apply(mirror.applied() + 1, event);
        }
    }
    [[nodiscard]] bool is_homed() const { return sessions.homes().of("robot").has_value(); }

    broker::Mirror mirror{peer};
    PeerSessions sessions;
    PeerLogs logs;
};

TEST_F(PeerSessionsTest, FollowALogUntilItEnds) {
    EXPECT_TRUE(sessions.follow(peer));
    EXPECT_TRUE(sessions.interest().wants("pose"));
    EXPECT_FALSE(sessions.follow(test::log_of("peer", 2))) << "its later life is another log";
    sessions.on_end(test::log_of("peer", 2));
    EXPECT_TRUE(sessions.follow(peer));
    sessions.on_end(peer);
    EXPECT_FALSE(sessions.follow(peer));
    sessions.on_turn();
    EXPECT_FALSE(sessions.interest().wants("pose"));
}

TEST_F(PeerSessionsTest, AHomeThatEndedStaysUntilALivingOneTakesItsPlace) {
    logs.try_emplace(peer, peer, 100);
    sessions.on_living_home("robot", logs);
    EXPECT_TRUE(is_homed()) << "that one lives itself";
    sessions.on_end(peer);
    EXPECT_TRUE(is_homed());
    sessions.on_living_home("robot", logs);
    EXPECT_FALSE(is_homed());
}

TEST_F(PeerSessionsTest, I7_AHomeWhoseLogHasEndedYieldsToALivingOne) {
    const auto end = {&PeerSessions::on_end, &PeerSessions::on_late_event};
    for (const auto on_end : end) {
        sessions.reset(peer, broker::Mirror{peer});
        sessions.on_event({}, broker::Mirror{heir}, test::session("robot"), 10);
        sessions.on_event({}, mirror, test::session("robot"), 10);
        EXPECT_EQ(sessions.homes().of("robot"), peer.broker) << "it said so last";
        (sessions.*on_end)(peer);
        EXPECT_EQ(sessions.homes().of("robot"), heir.broker);
    }
}

// A client that roams before an heir has it would be a stranger, and begin another session.
TEST_F(PeerSessionsTest, P2_WhereAFormerLifesClientsWereStaysUntilAnotherHomeHasThem) {
    const LogId later = test::log_of("peer", 2);
    for (const bool is_told_of_its_end : {true, false}) {
        sessions.reset(peer, broker::Mirror{peer});
        sessions.on_event({}, mirror, test::session("robot"), 10);
        if (is_told_of_its_end) sessions.on_end(peer);
        sessions.reset(later, broker::Mirror{later});
        EXPECT_EQ(sessions.homes().of("robot"), peer.broker);
        logs.try_emplace(later, later, 100);
        sessions.on_living_home("robot", logs);
        EXPECT_FALSE(is_homed());
        sessions.on_end(later);
    }
}

TEST_F(PeerSessionsTest, WhatAFormerLifeSaidIsForgottenWithItsLog) {
    const LogId later = test::log_of("peer", 2);
    sessions.reset(later, broker::Mirror{later});
    ASSERT_TRUE(is_homed());
    sessions.on_event({}, broker::Mirror{later}, test::session("another"), 10);
    sessions.forget(test::log_of("peer", 0));
    EXPECT_TRUE(is_homed());
    sessions.forget(peer);
    EXPECT_FALSE(is_homed());
    EXPECT_TRUE(sessions.homes().of("another"));
}

TEST_F(PeerSessionsTest, ALogThatIsHeldNoMoreIsForgotten) {
    sessions.reset(heir, broker::Mirror{heir});
    sessions.forget(peer);
    EXPECT_FALSE(is_homed());
    EXPECT_TRUE(sessions.follow(heir));
}

TEST_F(PeerSessionsTest, OfALogWhoseLateEventsTheyLackTheyDoNotHaveAll) {
    sessions.on_late_event(peer);
    EXPECT_FALSE(sessions.follow(peer));
    sessions.reset(peer, broker::Mirror{peer});
    EXPECT_TRUE(sessions.follow(peer));
    EXPECT_FALSE(is_homed());
}

TEST_F(PeerSessionsTest, NobodyWantsAnythingAtALogThatEndedWithLateEvents) {
    sessions.on_late_event(peer);
    EXPECT_TRUE(sessions.interest().wants("pose")) << "its broker may be a member yet";
    sessions.on_end(peer);
    sessions.on_turn();
    EXPECT_FALSE(sessions.interest().wants("pose"));
}

// Two lives of a broker are two logs, and subscriptions are counted by broker.
TEST_F(PeerSessionsTest, OnlyTheLogThatIsFollowedTellsWhatIsWanted) {
    broker::Mirror later{test::log_of("peer", 2)};
    for (const auto& event : {test::session("robot"), test::subscribed("robot", "pose"),
                              test::subscribed("robot", "map"), test::erased("robot")}) {
        sessions.on_event({}, later, event, 10);
        later.apply(later.applied() + 1, event);
        EXPECT_FALSE(sessions.interest().wants("map"));
    }
    EXPECT_TRUE(sessions.interest().wants("pose"));
}

TEST_F(PeerSessionsTest, WhatALaterPartOfTheFirstSnapshotSaysOfASessionIsWhatItWants) {
    const auto image_with = [](const char* client, const char* filter) {
        auto image = std::get<broker::SessionPut>(test::session(client)).image;
        image.subscriptions.push_back({.filter = filter});
        return image;
    };
    PeerLog log(heir, 10);
    const auto take = [&](const SnapshotPart& part) {
        ASSERT_TRUE(log.offer(part));
        sessions.on_first_snapshot(part, log.replaced());
    };
    take({.as_of = {heir, 5}, .sessions = {image_with("a", "old"), image_with("b", "gone")}});
    take({.as_of = {heir, 5}, .part = 1, .sessions = {image_with("a", "new")}, .gone = {"b"}});
    EXPECT_TRUE(sessions.interest().wants("new"));
    EXPECT_FALSE(sessions.interest().wants("old"));
    EXPECT_FALSE(sessions.interest().wants("gone"));
}

}  // namespace
}  // namespace romano::cluster::peer_sessions_test
