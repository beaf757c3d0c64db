// Kept sessions whose clients do not come back (Limits::session_expiry_s). MQTT-SN 1.2 says only
// that they are kept (section 6.3).

#include <gtest/gtest.h>

#include "tests/broker/core/scripted_client.h"

namespace romano::broker::session_expiry_test {
namespace {

BrokerOptions options_with(std::size_t expiry_s) {
    BrokerOptions options = logging_options();
    options.limits.session_expiry_s = expiry_s;
    return options;
}

constexpr std::size_t hour_s = 3600;

class SessionExpiry : public ::testing::Test {
protected:
    void leaves() {
        robot.says(Disconnect{});
        robot.hears<Disconnect>();
    }

    ScriptedBroker broker{options_with(hour_s)};
    ScriptedClient robot{broker, "robot"};
};

TEST_F(SessionExpiry, KeptSessionIsForgottenWhenItsClientStaysAway) {
    robot.connects(false);
    robot.subscribes("cmd");
    leaves();
    broker.waits(59min);
    EXPECT_TRUE(broker.core.image("robot"));
    broker.waits(1min);
    EXPECT_FALSE(broker.core.image("robot"));
    EXPECT_EQ(broker.core.counters().sessions_expired, 1u);
    EXPECT_EQ(std::get<SessionErased>(broker.log.back()).client_id, "robot");
    broker.expects_mirror_to_agree();
}

TEST_F(SessionExpiry, CountsFromTheLossOfASilentClient) {
    robot.connects(false, 60);
    broker.waits(90s);
    ASSERT_EQ(broker.core.image("robot")->header.state, SessionState::lost);
    broker.waits(59min);
    EXPECT_TRUE(broker.core.image("robot"));
    broker.waits(1min);
    EXPECT_FALSE(broker.core.image("robot"));
}

TEST_F(SessionExpiry, BeginsAnewWhenTheClientWasBack) {
    robot.connects(false);
    leaves();
    broker.waits(50min);
    robot.connects(false);
    leaves();
    broker.waits(50min);
    EXPECT_TRUE(broker.core.image("robot"));
}

TEST_F(SessionExpiry, DoesNotEndWhoIsConnectedOrAsleep) {
    robot.connects(false);
    ScriptedClient sleeper{broker, "sleeper"};
    sleeper.connects(false);
    sleeper.says(Disconnect{true, 4 * hour_s});
    broker.waits(5h);
    EXPECT_EQ(broker.core.session_count(), 2u);
}

TEST_F(SessionExpiry, OfZeroIsNever) {
    ScriptedBroker patient{options_with(0)};
    robot.moves_to(patient);
    robot.connects(false);
    leaves();
    patient.waits(std::chrono::hours{24 * 365});
    EXPECT_TRUE(patient.core.image("robot"));
}

// A new home goes on counting: what is restarted or taken over now and then expires as well.
TEST_F(SessionExpiry, GoesOnAtTheNextHome) {
    robot.connects(false);
    leaves();
    broker.expects_mirror_to_agree();
    ScriptedBroker heir{options_with(hour_s)};
    heir.now = broker.now + 40min;
    ASSERT_TRUE(heir.core.adopt(heir.now, *broker.mirror.image("robot"), {}, heir.actions));
    heir.drain();
    heir.waits(19min);
    EXPECT_TRUE(heir.core.image("robot"));
    heir.waits(1min);
    EXPECT_FALSE(heir.core.image("robot"));
    heir.expects_mirror_to_agree();
}

// The will's event is all that a mirror has of the loss.
TEST_F(SessionExpiry, GoesOnAtTheNextHomeAfterALossWithAWill) {
    Connect connect = robot.connect(false, 60);
    connect.will = true;
    robot.says(connect);
    robot.hears<Willtopicreq>();
    robot.says(Willtopic{Qos::at_least_once, false, "gone"});
    robot.hears<Willmsgreq>();
    robot.says(Willmsg{as_octets("robot")});
    robot.hears<Connack>();
    broker.waits(90s);
    broker.expects_mirror_to_agree();
    ScriptedBroker heir{options_with(hour_s)};
    heir.now = broker.now + 40min;
    ASSERT_TRUE(heir.core.adopt(heir.now, *broker.mirror.image("robot"), {}, heir.actions));
    heir.drain();
    heir.waits(19min);
    EXPECT_TRUE(heir.core.image("robot"));
    heir.waits(1min);
    EXPECT_FALSE(heir.core.image("robot"));
}

TEST_F(SessionExpiry, IsNotHastenedByAHomeWhoseClockIsBehind) {
    robot.connects(false);
    leaves();
    ScriptedBroker heir{options_with(hour_s)};
    broker.expects_mirror_to_agree();
    SessionImage image = *broker.mirror.image("robot");
    image.header.departed.value += std::uint64_t{1} << 40U;
    ASSERT_TRUE(heir.core.adopt(heir.now, image, {}, heir.actions));
    heir.drain();
    heir.waits(59min);
    EXPECT_TRUE(heir.core.image("robot"));
    heir.waits(1min);
    EXPECT_FALSE(heir.core.image("robot"));
}

}  // namespace
}  // namespace romano::broker::session_expiry_test
