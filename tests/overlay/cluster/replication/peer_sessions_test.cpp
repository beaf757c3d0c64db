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

}  // namespace
}  // namespace romano::cluster::peer_sessions_test
