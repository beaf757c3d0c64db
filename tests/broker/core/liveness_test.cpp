// Keep-alive, sleep, disconnection: MQTT-SN 1.2 sections 6.11, 6.12, 6.14 and the choices G6, G9,
// G10, G28.

#include <gtest/gtest.h>

#include "tests/broker/core/scripted_client.h"

namespace romano::broker::liveness_test {
namespace {

class Living : public ::testing::Test {
protected:
    [[nodiscard]] SessionState state_of(const ScriptedClient& client) const {
        return broker.core.image(client.id)->header.state;
    }

    void falls_asleep(std::uint16_t seconds) {
        robot.says(Disconnect{true, seconds});
        EXPECT_FALSE(robot.hears<Disconnect>().has_duration);
        EXPECT_EQ(state_of(robot), SessionState::asleep);
    }

    /// Of a robot that would hear what is published.
    void subscribes_and_falls_asleep() {
        robot.connects();
        robot.subscribes("cmd");
        publisher.connects();
        falls_asleep(1000);
    }

    /// PUBLISH was heard, and DISCONNECT said before the answer.
    MsgId falls_asleep_amid_qos2() {
        robot.connects();
        robot.subscribes("cmd", Qos::exactly_once);
        publisher.connects();
        publishes("x", Qos::exactly_once);
        const MsgId msg_id = robot.hears<Publish>().msg_id;
        falls_asleep(100);
        return msg_id;
    }

    void publishes(std::string_view data, Qos qos) {
        publisher.publishes(publisher.registers("cmd"), data, qos);
    }

    ScriptedBroker broker{logging_options()};
    ScriptedClient robot{broker, "robot"};
    ScriptedClient publisher{broker, "publisher"};
};

TEST_F(Living, PingreqIsAnsweredWithAndWithoutClientId) {  // 6.11a, G9
    robot.connects();
    robot.says(Pingreq{});
    robot.hears<Pingresp>();
    robot.says(Pingreq{"robot"});
    robot.hears<Pingresp>();
}

TEST_F(Living, SilenceIsToleratedForHalfAKeepAliveMore) {  // G6
    robot.connects(true, 20);
    broker.waits(29s);
    EXPECT_EQ(state_of(robot), SessionState::active);
    broker.waits(1s);
    EXPECT_EQ(state_of(robot), SessionState::lost);
}

/// emcute ignores DISCONNECT and never connects anew. Nothing that it says names it, so it is back
/// only when it is restarted.
TEST_F(Living, WhoWasLostAndDoesNotConnectAnewStaysLost) {  // 6.12, G8
    robot.connects(true, 360);
    robot.subscribes("cmd", Qos::at_most_once);
    const TopicId pose = robot.registers("pose");
    publisher.connects();
    publisher.subscribes("pose");
    broker.waits(9min);
    ASSERT_EQ(state_of(robot), SessionState::lost);
    robot.ignores_what_came();
    for (int i = 0; i < 3; ++i) {
        robot.publishes(pose, "x=1");
        robot.hears<Disconnect>();
        robot.says(Pingreq{});
        robot.hears<Disconnect>();
        publishes("go", Qos::at_least_once);
        robot.hears_nothing();
        publisher.hears_nothing();
    }
}

TEST_F(Living, ALossAndTheWillAreOneEvent) {  // P7: no heir knows of one without the other
    for (const Qos qos : {Qos::at_least_once, Qos::exactly_once}) {
        Connect connect = robot.connect(false, 20);
        connect.will = true;
        robot.says(connect);
        robot.hears<Willtopicreq>();
        robot.says(Willtopic{qos, false, "gone"});
        robot.hears<Willmsgreq>();
        robot.says(Willmsg{as_octets("robot")});
        robot.hears<Connack>();
        const std::size_t before = broker.log.size();
        broker.waits(30s);
        robot.ignores_what_came();
        ASSERT_EQ(state_of(robot), SessionState::lost);
        ASSERT_EQ(broker.log.size(), before + 1);
        const auto& event = std::get<Published>(broker.log.back());
        EXPECT_EQ(event.will_of, "robot");
        EXPECT_EQ(event.message->topic, "gone");
        broker.expects_mirror_to_agree();
    }
}

// P7: another broker hears it, or what it says waits.
TEST_F(Living, WhoCannotBeHeardIsNotLostForBeingSilent) {
    robot.connects(true, 20);
    broker.waits(30s - 1ms);
    broker.now += 1ms;
    broker.core.on_tick(broker.now, broker.actions, [](const SessionHeader&) { return true; });
    broker.waits(30s - 1ms);
    EXPECT_EQ(state_of(robot), SessionState::active) << "its keep-alive began anew";
    broker.waits(1ms);
    EXPECT_EQ(state_of(robot), SessionState::lost);
}

// P7: what it said meanwhile may wait to be read.
TEST_F(Living, NobodyIsLostForAStandstillOfTheBroker) {
    robot.connects(true, 20);
    broker.now += 45s;
    broker.waits(1s);
    EXPECT_EQ(state_of(robot), SessionState::active);
    broker.waits(30s);
    EXPECT_EQ(state_of(robot), SessionState::lost) << "its keep-alive began anew";
}

TEST_F(Living, AnyMessageRestartsKeepAlive) {  // 6.14
    robot.connects(true, 20);
    for (int i = 0; i < 5; ++i) {
        broker.waits(18s);
        robot.says(Register{no_topic_id, MsgId{1}, "a"});
    }
    EXPECT_EQ(state_of(robot), SessionState::active);
}

TEST_F(Living, KeepAliveZeroIsNotSupervised) {  // 2
    robot.connects(true, 0);
    broker.waits(24h);
    EXPECT_EQ(state_of(robot), SessionState::active);
    robot.hears_nothing();
}

TEST_F(Living, SilentClientIsProbedFromItsKeepAliveOn) {  // 6.11b, G6
    robot.connects(true, 60);
    broker.waits(59s);
    robot.hears_nothing();
    broker.waits(1s);
    robot.hears<Pingreq>();
    broker.waits(10s);
    robot.hears<Pingreq>();
    robot.says(Pingresp{});
    broker.waits(59s);
    robot.hears_nothing();
    EXPECT_EQ(state_of(robot), SessionState::active);
}

TEST_F(Living, DisconnectIsAnsweredWithoutDuration) {  // 6.12a, G28
    robot.connects();
    robot.says(Disconnect{});
    EXPECT_FALSE(robot.hears<Disconnect>().has_duration);
    EXPECT_EQ(state_of(robot), SessionState::disconnected);
    robot.says(Disconnect{});  // asymcute repeats
    robot.hears<Disconnect>();
}

TEST_F(Living, DisconnectWithDurationZeroIsPlain) {  // G28
    robot.connects();
    robot.says(Disconnect{true, 0});
    robot.hears<Disconnect>();
    EXPECT_EQ(state_of(robot), SessionState::disconnected);
}

TEST_F(Living, SleeperGetsEverythingWhenItWakesUpAndThenPingresp) {  // 6.14a, 6.14b
    robot.connects(true, 10);
    robot.subscribes("cmd");
    publisher.connects();
    falls_asleep(100);
    publishes("0", Qos::at_most_once);
    publishes("1", Qos::at_least_once);
    publishes("2", Qos::exactly_once);
    broker.waits(90s);
    robot.hears_nothing();
    robot.says(Pingreq{"robot"});
    EXPECT_EQ(state_of(robot), SessionState::awake);
    robot.hears_publish("0");
    robot.hears_publish("1", Qos::at_least_once);
    robot.hears_publish("2", Qos::exactly_once);
    robot.hears<Pingresp>();
    EXPECT_EQ(state_of(robot), SessionState::asleep);
    broker.expects_mirror_to_agree();
}

TEST_F(Living, SleeperWithNothingBufferedGetsPingrespAtOnce) {  // 6.14c
    robot.connects();
    falls_asleep(100);
    robot.says(Pingreq{"robot"});
    robot.hears<Pingresp>();
    EXPECT_EQ(state_of(robot), SessionState::asleep);
}

TEST_F(Living, SleeperUnderAWildcardIsToldNamesWhenAwake) {  // 6.14b, Paho issue 121
    robot.connects();
    robot.subscribes("#");
    publisher.connects();
    falls_asleep(100);
    publishes("x", Qos::at_least_once);
    robot.says(Pingreq{"robot"});
    robot.hears_register("cmd");
    robot.hears_publish("x", Qos::at_least_once);
    robot.hears<Pingresp>();
}

// Else the message came again under an id that the client has forgotten.
TEST_F(Living, AnswersThatComeBehindTheDisconnectEndTheExchange) {  // 6.14, QoS 2
    const MsgId msg_id = falls_asleep_amid_qos2();
    robot.says(Pubrec{msg_id});
    EXPECT_EQ(robot.hears<Pubrel>().msg_id, msg_id);
    robot.says(Pubcomp{msg_id});
    robot.says(Pingreq{"robot"});
    robot.hears<Pingresp>();
}

TEST_F(Living, ASleeperThatWasReleasedIsAskedToCompleteWhenItWakesUp) {  // 6.14, QoS 2
    const MsgId msg_id = falls_asleep_amid_qos2();
    robot.says(Pubrec{msg_id});
    robot.hears<Pubrel>();
    robot.says(Pingreq{"robot"});
    EXPECT_EQ(robot.hears<Pubrel>().msg_id, msg_id);
    robot.says(Pubcomp{msg_id});
    robot.hears<Pingresp>();
}

TEST_F(Living, SleeperThatStaysAwayIsLost) {  // 6.14
    robot.connects();
    falls_asleep(100);
    broker.waits(149s);
    EXPECT_EQ(state_of(robot), SessionState::asleep);
    broker.waits(1s);
    EXPECT_EQ(state_of(robot), SessionState::lost);
    robot.says(Pingreq{"robot"});
    robot.hears<Disconnect>();  // G9: it connects again
}

TEST_F(Living, EachAwakeningRestartsTheSleepTimer) {  // 6.14
    robot.connects();
    falls_asleep(100);
    for (int i = 0; i < 5; ++i) {
        broker.waits(120s);
        robot.says(Pingreq{"robot"});
        robot.hears<Pingresp>();
    }
    EXPECT_EQ(state_of(robot), SessionState::asleep);
}

TEST_F(Living, SleeperMayChangeItsSleepingTime) {  // 6.14
    robot.connects();
    falls_asleep(10);
    falls_asleep(1000);
    broker.waits(900s);
    EXPECT_EQ(state_of(robot), SessionState::asleep);
}

TEST_F(Living, PlainDisconnectEndsSleep) {  // 6.14, G28
    robot.connects();
    falls_asleep(10);
    robot.says(Disconnect{});
    robot.hears<Disconnect>();
    EXPECT_EQ(state_of(robot), SessionState::disconnected);
}

TEST_F(Living, AwakeClientThatStopsAnsweringSleepsOnAndLosesNothing) {  // G10
    subscribes_and_falls_asleep();
    publishes("x", Qos::at_least_once);
    robot.says(Pingreq{"robot"});
    broker.waits(41s);
    EXPECT_EQ(state_of(robot), SessionState::asleep);
    EXPECT_EQ(robot.unheard(), 4u);
    robot.ignores_what_came();
    robot.says(Pingreq{"robot"});
    EXPECT_TRUE(robot.hears_publish("x", Qos::at_least_once).dup);
    robot.hears<Pingresp>();
    broker.expects_mirror_to_agree();
}

TEST_F(Living, AwakeClientThatAskedOnceMoreAndIsOutOfReachLosesNothing) {  // G5, G10
    subscribes_and_falls_asleep();
    publishes("x", Qos::at_least_once);
    robot.says(Pingreq{"robot"});
    broker.waits(9s);
    robot.says(Pingreq{"robot"});
    broker.waits(41s);
    EXPECT_EQ(state_of(robot), SessionState::asleep);
    EXPECT_EQ(broker.dropped(Drop::retries_exhausted), 0u);
    robot.ignores_what_came();
    robot.says(Pingreq{"robot"});
    robot.hears_publish("x", Qos::at_least_once);
    robot.hears<Pingresp>();
    broker.expects_mirror_to_agree();
}

TEST_F(Living, AwakeClientThatTakesOneMessageNeverGetsTheNext) {  // G5: asymcute's buffer
    subscribes_and_falls_asleep();
    publishes("too long", Qos::at_least_once);
    publishes("2", Qos::at_least_once);
    for (int asked = 0; asked < 5; ++asked) {
        robot.says(Pingreq{"robot"});
        broker.waits(9s);
    }
    EXPECT_EQ(broker.dropped(Drop::retries_exhausted), 0u);
    broker.waits(1s);
    EXPECT_EQ(broker.dropped(Drop::retries_exhausted), 1u);
    for (int sending = 0; sending < 5; ++sending) {
        EXPECT_EQ(as_text(robot.hears<Publish>().data), "too long");
    }
    robot.hears_publish("2", Qos::at_least_once);
    robot.hears<Pingresp>();
    broker.expects_mirror_to_agree();
}

TEST_F(Living, WhatASleeperPassesOverIsCountedFromOneAwakeningToTheNext) {  // G5, G10
    subscribes_and_falls_asleep();
    publishes("too long", Qos::exactly_once);
    publishes("2", Qos::at_least_once);
    for (int awakening = 0; awakening < 4; ++awakening) {
        EXPECT_EQ(broker.dropped(Drop::retries_exhausted), 0u);
        robot.ignores_what_came();
        robot.says(Pingreq{"robot"});
        broker.waits(9s);
        robot.says(Pingreq{"robot"});
        broker.waits(31s);
    }
    EXPECT_EQ(broker.dropped(Drop::retries_exhausted), 1u);
    for (int sending = 0; sending < 4; ++sending) robot.hears<Publish>();
    robot.hears_publish("2", Qos::at_least_once);
    robot.hears<Pingresp>();
    broker.expects_mirror_to_agree();
}

TEST_F(Living, CongestionOfAnAwakeClientLetsItSleepOn) {  // G10
    subscribes_and_falls_asleep();
    publishes("x", Qos::at_least_once);
    for (int awakening = 0; awakening < 10; ++awakening) {
        robot.says(Pingreq{"robot"});
        const auto publish = robot.hears<Publish>();
        robot.says(Puback{publish.topic, publish.msg_id, ReturnCode::congestion});
        robot.hears<Pingresp>();
        EXPECT_EQ(state_of(robot), SessionState::asleep);
    }
    broker.waits(10min);
    robot.says(Pingreq{"robot"});
    robot.hears_publish("x", Qos::at_least_once);
    robot.hears<Pingresp>();
    EXPECT_EQ(broker.dropped(Drop::retries_exhausted), 0u);
    broker.expects_mirror_to_agree();
}

TEST_F(Living, PingreqWhileAwakeAsksForTheOpenMessageAgain) {  // G10
    subscribes_and_falls_asleep();
    publishes("x", Qos::at_least_once);
    robot.says(Pingreq{"robot"});
    const MsgId msg_id = robot.hears<Publish>().msg_id;
    robot.says(Pingreq{"robot"});
    const auto again = robot.hears<Publish>();
    EXPECT_EQ(again.msg_id, msg_id);
    EXPECT_TRUE(again.dup);
}

TEST_F(Living, ConnectOfASleeperMakesItActiveAndSendsWhatIsBuffered) {  // 6.14e
    robot.connects(false);
    robot.subscribes("cmd");
    publisher.connects();
    falls_asleep(1000);
    publishes("x", Qos::at_least_once);
    robot.connects(false);
    robot.hears_register("cmd");
    robot.hears_publish("x", Qos::at_least_once);
    robot.hears_nothing();
    EXPECT_EQ(state_of(robot), SessionState::active);
}

TEST_F(Living, SleeperMayComeFromANewAddress) {  // 6.14e, G9
    subscribes_and_falls_asleep();
    publishes("x", Qos::at_least_once);
    ScriptedClient moved{broker, "robot"};
    moved.says(Pingreq{"robot"});
    moved.hears_publish("x", Qos::at_least_once);
    moved.hears<Pingresp>();
    robot.hears_nothing();
    broker.expects_mirror_to_agree();
}

TEST_F(Living, PingreqInAnotherActiveClientsNameIsRefused) {  // G9
    robot.connects();
    ScriptedClient thief{broker, "robot"};
    thief.says(Pingreq{"robot"});
    thief.hears<Disconnect>();
    EXPECT_EQ(broker.core.image("robot")->header.address, robot.address);
}

TEST_F(Living, SleepersOtherRequestsAreServedAndItSleepsOn) {  // G10
    robot.connects();
    falls_asleep(100);
    broker.waits(100s);
    robot.registers("a");
    EXPECT_EQ(state_of(robot), SessionState::asleep);
    broker.waits(100s);
    EXPECT_EQ(state_of(robot), SessionState::asleep);
}

TEST_F(Living, TicksThatComeEarlyOrTwiceAreHarmless) {
    robot.connects(true, 60);
    for (int i = 0; i < 100; ++i) {
        broker.core.on_tick(broker.now, broker.actions);
        broker.drain();
    }
    robot.hears_nothing();
    EXPECT_GT(broker.core.next_wakeup(), broker.now);
}

}  // namespace
}  // namespace romano::broker::liveness_test
