// Sections 6.2 and 6.3: setting a connection up, and what of a session survives it.

#include "tests/conformance/suite.h"

namespace romano::conformance::connect_test {
namespace {

CONFORMANCE_SUITE(S6_2_Connect, PatientSuite);

TEST_P(S6_2_Connect, a_WithoutWillIsAnsweredAtOnce) {
    Client& robot = client();
    robot.says(connect(robot.id));
    robot.hears({0x03, 0x05, 0x00});
}

TEST_P(S6_2_Connect, b_WithWillPromptsForTopicAndMessage) {
    Client& robot = client();
    robot.says(connect(robot.id, clean | with_will));
    robot.hears({0x02, 0x06});
    robot.says(willtopic(topic()));
    robot.hears({0x02, 0x08});
    robot.says(willmsg("gone"));
    robot.hears({0x03, 0x05, 0x00});
}

TEST_P(S6_2_Connect, b_NobodyIsActiveBeforeConnack) {
    Client& robot = client();
    robot.says(connect(robot.id, clean | with_will));
    robot.hears(willtopicreq());
    robot.says(subscribe(no_flags, 1, topic()));
    robot.hears(disconnect());  // G8: no session is here
    robot.says(willtopic(topic()));
    robot.hears(willmsgreq());
    robot.says(willmsg("gone"));
    robot.hears(connack(accepted));
}

TEST_P(S6_2_Connect, b_AWillMessageMayBeEmpty) {
    Client& robot = client();
    robot.connects_with_will(topic(), "");
}

TEST_P(S6_2_Connect, c_AnotherProtocolIdIsRefused) {
    Client& robot = client();
    for (const unsigned protocol : {0U, 2U, 255U}) {
        robot.says(connect(robot.id, clean, 0, protocol));
        robot.hears(connack(not_supported));
    }
}

TEST_P(S6_2_Connect, c_ARefusedClientHasNoSession) {
    Client& robot = client();
    robot.says(connect(robot.id, clean, 0, 2));
    robot.hears(connack(not_supported));
    robot.says(pingreq());
    robot.hears(disconnect());
}

TEST_P(S6_2_Connect, c_AWillTopicWithWildcardsIsRefusedAfterThePrompts) {  // G13
    for (const std::string wrong : {"a/#", "+", "a+"}) {
        Client& robot = client();
        robot.says(connect(robot.id, clean | with_will));
        robot.hears(willtopicreq());
        robot.says(willtopic(wrong));
        robot.hears(willmsgreq());
        robot.says(willmsg("gone"));
        robot.hears(connack(not_supported));
    }
}

TEST_P(S6_2_Connect, c_AWillOfQosMinus1IsRefusedAfterThePrompts) {
    Client& robot = client();
    robot.says(connect(robot.id, clean | with_will));
    robot.hears(willtopicreq());
    robot.says(willtopic(topic(), qos_minus_1));
    robot.hears(willmsgreq());
    robot.says(willmsg("gone"));
    robot.hears(connack(not_supported));
}

TEST_P(S6_2_Connect, c_AnotherProtocolIdIsRefusedAlsoWithAWill) {
    Client& robot = client();
    robot.says(connect(robot.id, clean | with_will, 0, 2));
    robot.hears(willtopicreq());
    robot.says(willtopic(topic()));
    robot.hears(willmsgreq());
    robot.says(willmsg("gone"));
    robot.hears(connack(not_supported));
}

TEST_P(S6_2_Connect, d_ARepeatedConnectIsAnsweredAgain) {
    Client& robot = connected();
    robot.says(connect(robot.id));
    robot.hears(connack(accepted));
}

TEST_P(S6_2_Connect, d_ARepeatedConnectStartsThePromptsAgain) {
    Client& robot = client();
    for (int i = 0; i < 3; ++i) {
        robot.says(connect(robot.id, clean | with_will));
        robot.hears(willtopicreq());
    }
    robot.says(willtopic(topic()));
    robot.hears(willmsgreq());
    robot.says(connect(robot.id, clean | with_will));
    robot.hears(willtopicreq());
}

TEST_P(S6_2_Connect, d_RepeatedWillMessagesAreAnsweredAgain) {
    Client& robot = client();
    robot.says(connect(robot.id, clean | with_will));
    robot.hears(willtopicreq());
    for (int i = 0; i < 2; ++i) {
        robot.says(willtopic(topic()));
        robot.hears(willmsgreq());
    }
    for (int i = 0; i < 2; ++i) {
        robot.says(willmsg("gone"));
        robot.hears(connack(accepted));
    }
}

TEST_P(S6_2_Connect, d_WillMessagesWithoutAPromptAreIgnored) {
    Client& robot = client();
    robot.says(willtopic(topic()));
    robot.says(willmsg("gone"));
    hears_nothing(robot);
    robot.connects();
    robot.says(willtopic(topic()));
    robot.says(willmsg("gone"));
    hears_nothing(robot);
}

TEST_P(S6_2_Connect, d_WillmsgBeforeItsPromptIsIgnored) {
    Client& robot = client();
    robot.says(connect(robot.id, clean | with_will));
    robot.hears(willtopicreq());
    robot.says(willmsg("gone"));
    hears_nothing(robot);
}

TEST_P(S6_2_Connect, d_AConnectWithoutWillEndsThePrompts) {
    Client& robot = client();
    robot.says(connect(robot.id, clean | with_will));
    robot.hears(willtopicreq());
    robot.says(connect(robot.id));
    robot.hears(connack(accepted));
    robot.says(willtopic(topic()));
    hears_nothing(robot);
}

TEST_P(S6_2_Connect, ClientIdsHave1To23Octets) {  // 5.3.1
    const std::string long_id = unique("a-client-id-of-23-octets");
    for (const std::string& id : {std::string{"q"}, long_id.substr(long_id.size() - 23)}) {
        Client& robot = client(id);
        robot.connects();
    }
}

TEST_P(S6_2_Connect, g20_LongerClientIdsAreTakenUpTo64Octets) {
    const std::string id = unique(std::string(64, 'i'));
    Client& robot = client(id.substr(id.size() - 64));
    robot.connects();
}

TEST_P(S6_2_Connect, ClientIdsAreToldApartByCaseAndEveryOctet) {
    const std::string id = unique("id");
    Client& one = client(id + "a");
    Client& other = client(id + "A");
    one.connects();
    other.connects();
    one.says(pingreq());
    one.hears(pingresp());
}

TEST_P(S6_2_Connect, g20_AnEmptyClientIdIsTakenWithACleanSession) {
    Client& one = client("");
    Client& other = client("");
    one.connects();
    other.connects();
    const unsigned id = one.subscribes(topic());
    one.publishes(id, "x");
    one.hears_publish(no_flags, id, "x");  // still its session
}

TEST_P(S6_2_Connect, g20_AnEmptyClientIdIsRefusedForAKeptSession) {
    Client& robot = client("");
    robot.says(connect("", no_flags));
    robot.hears(connack(not_supported));
}

TEST_P(S6_2_Connect, g7_AConnectOfALivingSessionBeginsAnewAndPublishesNoWill) {
    Client& watcher = connected();
    watcher.subscribes(topic("will"));
    Client& robot = client();
    robot.connects_with_will(topic("will"), "gone");
    robot.subscribes(topic());
    robot.connects(clean);
    Client& publisher = connected();
    publisher.publishes(publisher.registers(topic()), "x");
    hears_nothing(robot);
    hears_nothing(watcher);
}

TEST_P(S6_2_Connect, g7_TheSameClientIdFromANewAddressMovesTheSession) {
    Client& robot = connected(no_flags);
    const unsigned id = robot.subscribes(topic());
    Client& moved = client(robot.id);
    moved.connects(no_flags);
    Client& publisher = connected();
    publisher.publishes(publisher.registers(topic()), "x");
    const auto told = moved.hears_register(topic());
    EXPECT_EQ(told.topic_id, id);  // G14: ids never change within a kept session
    moved.takes(no_flags, id, "x");
    hears_nothing(robot);
    robot.says(pingreq());
    robot.hears(disconnect());  // its old address is a stranger's
}

TEST_P(S6_2_Connect, g7_AnotherClientIdTakesTheAddressOver) {
    Client& robot = connected();
    robot.subscribes(topic());
    robot.says(connect(unique("other")));
    robot.hears(connack(accepted));
    Client& publisher = connected();
    publisher.publishes(publisher.registers(topic()), "x");
    hears_nothing(robot);  // the new owner did not subscribe
}

TEST_P(S6_2_Connect, g27_AnswersComeFromTheAddressThatWasAsked) {
    connected();  // a client's socket hears that address and port only
}

CONFORMANCE_SUITE(S6_3_CleanSession, PatientSuite);

TEST_P(S6_3_CleanSession, Set_ErasesSubscriptions) {
    Client& robot = connected(no_flags);
    robot.subscribes(topic());
    robot.disconnects();
    robot.connects(clean);
    Client& publisher = connected();
    publisher.publishes(publisher.registers(topic()), "x", 1);
    hears_nothing(robot);
}

TEST_P(S6_3_CleanSession, Set_ErasesTopicIds) {
    Client& robot = connected(no_flags);
    const unsigned id = robot.registers(topic());
    robot.disconnects();
    robot.connects(clean);
    robot.says(publish(qos1, id, 9, "x"));
    robot.hears(puback(id, 9, invalid_topic_id));
}

TEST_P(S6_3_CleanSession, Set_ErasesWhatWasQueued) {
    Client& robot = connected(no_flags);
    robot.subscribes(topic(), 1);
    robot.disconnects();
    Client& publisher = connected();
    publisher.publishes(publisher.registers(topic()), "x", 1);
    robot.connects(clean);
    hears_nothing(robot);
}

TEST_P(S6_3_CleanSession, Set_EndsHalfDoneQos2) {
    Client& robot = connected(no_flags);
    const unsigned id = robot.subscribes(topic());
    robot.says(publish(qos2, id, 9, "x"));
    robot.hears(pubrec(9));
    robot.hears_publish(no_flags, id, "x");
    robot.connects(clean);
    const unsigned again = robot.subscribes(topic());
    robot.says(publish(dup | qos2, again, 9, "y"));  // another message: nothing was before
    robot.hears(pubrec(9));
    robot.hears_publish(no_flags, again, "y");
}

TEST_P(S6_3_CleanSession, Unset_KeepsSubscriptionsAndIds) {
    Client& robot = connected(no_flags);
    const unsigned id = robot.subscribes(topic());
    robot.disconnects();
    robot.connects(no_flags);
    Client& publisher = connected();
    publisher.publishes(publisher.registers(topic()), "x");
    EXPECT_EQ(robot.hears_register(topic()).topic_id, id);
    robot.takes(no_flags, id, "x");
    EXPECT_EQ(robot.registers(topic()), id);
    robot.publishes(id, "y", 1);
}

TEST_P(S6_3_CleanSession, Unset_KeepsMessagesOfQos1And2InOrder) {
    Client& robot = connected(no_flags);
    const unsigned id = robot.subscribes(topic(), 2);
    robot.disconnects();
    Client& publisher = connected();
    const unsigned at_publisher = publisher.registers(topic());
    publisher.publishes(at_publisher, "1", 1);
    publisher.publishes(at_publisher, "2", 2);
    publisher.publishes(at_publisher, "3", 1);
    hears_nothing(robot);
    robot.connects(no_flags);
    EXPECT_EQ(robot.hears_register(topic()).topic_id, id);
    robot.takes(qos1, id, "1");
    robot.takes(qos2, id, "2");
    robot.takes(qos1, id, "3");
    hears_nothing(robot);
}

TEST_P(S6_3_CleanSession, Unset_KeepsAQos2PublishWhosePubrelIsOutstanding) {
    Client& watcher = connected();
    const unsigned at_watcher = watcher.subscribes(topic());
    Client& robot = connected(no_flags);
    const unsigned id = robot.registers(topic());
    robot.says(publish(qos2, id, 9, "x"));
    robot.hears(pubrec(9));
    watcher.hears_publish(no_flags, at_watcher, "x");
    robot.connects(no_flags);
    robot.says(publish(dup | qos2, id, 9, "x"));
    robot.hears(pubrec(9));
    robot.says(pubrel(9));
    robot.hears(pubcomp(9));
    hears_nothing(watcher);  // not twice
}

TEST_P(S6_3_CleanSession, Unset_SendsAgainWhatWasNotAcknowledged) {
    Client& robot = connected(no_flags);
    const unsigned id = robot.subscribes(topic(), 1);
    robot.publishes(id, "x", 1);
    const unsigned msg_id = robot.hears_publish(qos1, id, "x");
    robot.connects(no_flags);
    EXPECT_EQ(robot.hears_register(topic()).topic_id, id);
    EXPECT_EQ(robot.hears_publish(dup | qos1, id, "x"), msg_id);
    robot.says(puback(id, msg_id));
}

TEST_P(S6_3_CleanSession, Unset_GoesOnWithPubrelWherePubrecHadCome) {
    Client& robot = connected(no_flags);
    const unsigned id = robot.subscribes(topic(), 2);
    robot.publishes(id, "x", 1);  // delivered at QoS 1
    robot.takes(qos1, id, "x");
    robot.says(publish(qos2, id, 9, "y"));
    robot.hears(pubrec(9));
    const unsigned msg_id = robot.hears_publish(qos2, id, "y");
    robot.says(pubrec(msg_id));
    robot.hears(pubrel(msg_id));
    robot.connects(no_flags);
    robot.hears(pubrel(msg_id));  // and not the message once more
    robot.says(pubcomp(msg_id));
    hears_nothing(robot);
}

TEST_P(S6_3_CleanSession, g12_ConnackComesBeforeAnythingElse) {
    Client& robot = connected(no_flags);
    robot.subscribes(topic(), 1);
    robot.disconnects();
    Client& publisher = connected();
    publisher.publishes(publisher.registers(topic()), "x", 1);
    robot.says(connect(robot.id, no_flags));
    robot.hears(connack(accepted));
    robot.hears_register(topic());
}

TEST_P(S6_3_CleanSession, g11_IsErasedNoSoonerThanAtTheNextCleanConnect) {
    Client& robot = connected(clean);
    const unsigned id = robot.subscribes(topic());
    robot.disconnects();
    robot.connects(no_flags);  // cc.mqttsn's clients connect so and count on it
    Client& publisher = connected();
    publisher.publishes(publisher.registers(topic()), "x");
    EXPECT_EQ(robot.hears_register(topic()).topic_id, id);
    robot.takes(no_flags, id, "x");
}

}  // namespace
}  // namespace romano::conformance::connect_test
