// Section 6.14: sleeping clients.

#include "tests/conformance/suite.h"

namespace romano::conformance::sleep_test {
namespace {

class Sleeping : public PatientSuite {
protected:
    /// A client that subscribed to the case's topic at QoS 2 and went to sleep.
    Client& sleeper(Flags flags = clean) {
        Client& one = connected(flags);
        id_ = one.subscribes(topic(), 2);
        one.sleeps();
        return one;
    }
    [[nodiscard]] unsigned id() const { return id_; }

    void publishes(const std::string& data, int qos) {
        if (publisher_ == nullptr) publisher_ = &connected();
        publisher_->publishes(publisher_->registers(topic()), data, qos);
    }

private:
    unsigned id_ = 0;
    Client* publisher_ = nullptr;
};

CONFORMANCE_SUITE(S6_14_Sleep, Sleeping);

TEST_P(S6_14_Sleep, a_DisconnectWithDurationIsAnsweredWithoutOne) {  // G28
    Client& robot = connected();
    robot.says(disconnect_for(60));
    robot.hears({0x02, 0x18});
}

TEST_P(S6_14_Sleep, a_MessagesOfEveryQosWaitForASleeper) {
    Client& robot = sleeper();
    publishes("0", 0);
    publishes("1", 1);
    publishes("2", 2);
    hears_nothing(robot);
    robot.says(pingreq(robot.id));
    robot.takes(no_flags, id(), "0");
    robot.takes(qos1, id(), "1");
    robot.takes(qos2, id(), "2");
    robot.hears(pingresp());
}

TEST_P(S6_14_Sleep, c_WithNothingThereThePingrespComesAtOnce) {
    Client& robot = sleeper();
    robot.says(pingreq(robot.id));
    robot.hears(pingresp());
}

TEST_P(S6_14_Sleep, b_AfterPingrespItSleepsAgain) {
    Client& robot = sleeper();
    for (const std::string data : {"1", "2"}) {
        publishes(data, 1);
        hears_nothing(robot);
        robot.says(pingreq(robot.id));
        robot.takes(qos1, id(), data);
        robot.hears(pingresp());
    }
    publishes("3", 0);
    hears_nothing(robot);
}

TEST_P(S6_14_Sleep, b_MessagesComeOneAfterTheOtherWithTheirAnswers) {
    Client& robot = sleeper();
    publishes("1", 1);
    publishes("2", 1);
    robot.says(pingreq(robot.id));
    const unsigned msg_id = robot.hears_publish(qos1, id(), "1");
    hears_nothing(robot);
    robot.says(puback(id(), msg_id));
    robot.takes(qos1, id(), "2");
    robot.hears(pingresp());
}

TEST_P(S6_14_Sleep, b_RegisterComesWhileAwake) {
    Client& robot = connected();
    robot.subscribes(topic("+"), 1);
    robot.sleeps();
    Client& publisher = connected();
    publisher.publishes(publisher.registers(topic("a")), "x", 1);
    hears_nothing(robot);
    robot.says(pingreq(robot.id));
    robot.takes(qos1, robot.hears_register(topic("a")).topic_id, "x");
    robot.hears(pingresp());
}

TEST_P(S6_14_Sleep, g10_PingreqWhileAwakeBringsTheOpenMessageAgain) {
    Client& robot = sleeper();
    publishes("1", 1);
    robot.says(pingreq(robot.id));
    const unsigned msg_id = robot.hears_publish(qos1, id(), "1");
    robot.says(pingreq(robot.id));
    EXPECT_EQ(robot.hears_publish(dup | qos1, id(), "1"), msg_id);
    robot.says(puback(id(), msg_id));
    robot.hears(pingresp());
}

TEST_P(S6_14_Sleep, g9_PingreqWithoutClientIdWakesItToo) {
    Client& robot = sleeper();
    publishes("1", 1);
    robot.says(pingreq());
    robot.takes(qos1, id(), "1");
    robot.hears(pingresp());
}

TEST_P(S6_14_Sleep, e_ItMayWakeUpAtAnotherAddress) {  // G9
    Client& robot = sleeper();
    publishes("1", 1);
    Client& moved = client(robot.id);
    moved.says(pingreq(robot.id));
    moved.takes(qos1, id(), "1");
    moved.hears(pingresp());
    hears_nothing(robot);
}

TEST_P(S6_14_Sleep, g9_AnUnknownClientIdHearsDisconnect) {
    Client& stranger = client();
    stranger.says(pingreq(stranger.id));
    stranger.hears(disconnect());
}

TEST_P(S6_14_Sleep, e_ConnectWakesItForGoodAndBringsItsMessages) {
    Client& robot = sleeper(no_flags);
    publishes("1", 1);
    publishes("2", 2);
    robot.connects(no_flags);
    EXPECT_EQ(robot.hears_register(topic()).topic_id, id());
    robot.takes(qos1, id(), "1");
    robot.takes(qos2, id(), "2");
    publishes("3", 0);
    robot.takes(no_flags, id(), "3");  // active: nothing waits
}

TEST_P(S6_14_Sleep, g10_AConnectWithCleanSessionErasesItsMessages) {
    Client& robot = sleeper();
    publishes("1", 1);
    robot.connects(clean);
    hears_nothing(robot);
}

TEST_P(S6_14_Sleep, DisconnectEndsTheSleep) {  // G28
    Client& robot = sleeper();
    robot.disconnects();
    robot.says(pingreq(robot.id));
    robot.hears(disconnect());
}

TEST_P(S6_14_Sleep, ItMayGoToSleepAgainWithAnotherDuration) {
    Client& robot = sleeper();
    robot.sleeps(10);
    publishes("1", 1);
    robot.says(pingreq(robot.id));
    robot.takes(qos1, id(), "1");
    robot.hears(pingresp());
}

TEST_P(S6_14_Sleep, ItMayGoToSleepWhileAwake) {
    Client& robot = sleeper();
    publishes("1", 1);
    robot.says(pingreq(robot.id));
    const unsigned msg_id = robot.hears_publish(qos1, id(), "1");
    robot.sleeps(60);
    hears_nothing(robot);
    robot.says(pingreq(robot.id));
    EXPECT_EQ(robot.hears_publish(dup | qos1, id(), "1"), msg_id);  // not lost
    robot.says(puback(id(), msg_id));
    robot.hears(pingresp());
}

TEST_P(S6_14_Sleep, g10_ASleepersRequestsAreServedAndItSleepsOn) {
    Client& robot = sleeper();
    robot.says(publish(qos1, id(), 9, "own"));
    robot.hears(puback(id(), 9));
    hears_nothing(robot);  // its own copy waits
    robot.says(pingreq(robot.id));
    robot.takes(qos1, id(), "own");
    robot.hears(pingresp());
}

TEST_P(S6_14_Sleep, ASleeperThatDoesNotComeBackIsLost) {
    Client& robot = connected();
    Client& watcher = connected();
    const unsigned will_id = watcher.subscribes(topic("will"));
    robot.says(willtopicupd(topic("will")));
    robot.hears(willtopicresp(accepted));
    robot.sleeps(1);
    watcher.hears_publish(no_flags, will_id, "");
    robot.says(pingreq(robot.id));
    robot.hears(disconnect());
}

TEST_P(S6_14_Sleep, b_AHalfDoneQos2GoesOnWhenItWakesUpAgain) {
    Client& robot = sleeper();
    publishes("x", 2);
    robot.says(pingreq(robot.id));
    const unsigned msg_id = robot.hears_publish(qos2, id(), "x");
    robot.says(pubrec(msg_id));
    robot.hears(pubrel(msg_id));
    robot.sleeps();
    robot.says(pingreq(robot.id));
    robot.hears(pubrel(msg_id));
    robot.says(pubcomp(msg_id));
    robot.hears(pingresp());
}

TEST_P(S6_14_Sleep, RetainedMessagesOfASleepersSubscriptionWaitToo) {
    Client& publisher = connected();
    retains(publisher, topic("kept"), "kept", 1);
    Client& robot = connected();
    robot.sleeps();
    robot.says(subscribe(qos1, 9, topic("kept")));
    const Octets answer = robot.next();
    ASSERT_EQ(answer.size(), 8u) << describe(answer);
    hears_nothing(robot);
    robot.says(pingreq(robot.id));
    robot.takes(qos1 | retain, static_cast<unsigned>(answer[3] << 8U | answer[4]), "kept");
    robot.hears(pingresp());
}

}  // namespace
}  // namespace romano::conformance::sleep_test
