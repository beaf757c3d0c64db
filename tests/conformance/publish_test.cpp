// Sections 6.6 to 6.8: PUBLISH from the client, at every QoS and with every type of topic id.

#include "tests/conformance/suite.h"

namespace romano::conformance::publish_test {
namespace {

CONFORMANCE_SUITE(S6_6_Publish, PatientSuite);

TEST_P(S6_6_Publish, a_Qos0IsDeliveredAndNotAnswered) {
    Client& robot = connected();
    Client& watcher = connected();
    const unsigned at_watcher = watcher.subscribes(topic());
    const unsigned id = robot.registers(topic());
    robot.says(publish(no_flags, id, 0, "x"));
    watcher.hears_publish(no_flags, at_watcher, "x");
    hears_nothing(robot);
}

TEST_P(S6_6_Publish, a_Qos1IsAnsweredByPubackWithItsIds) {  // G22
    Client& robot = connected();
    const unsigned id = robot.registers(topic());
    robot.says(publish(qos1, id, 0x1234, "x"));
    robot.hears(puback(id, 0x1234));
}

TEST_P(S6_6_Publish, a_Qos2IsAnsweredByPubrecAndPubcomp) {
    Client& robot = connected();
    const unsigned id = robot.registers(topic());
    robot.says(publish(qos2, id, 0x1234, "x"));
    robot.hears({0x04, 0x0F, 0x12, 0x34});
    robot.says(pubrel(0x1234));
    robot.hears({0x04, 0x0E, 0x12, 0x34});
    hears_nothing(robot);
}

TEST_P(S6_6_Publish, AnEmptyMessageIsAMessage) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic());
    robot.publishes(id, "", 1);
    robot.hears_publish(no_flags, id, "");
}

TEST_P(S6_6_Publish, b_AnUnknownIdIsAnsweredByPubackAtEveryQos) {
    Client& robot = connected();
    robot.says(publish(no_flags, 0x0777, 0, "x"));
    robot.hears(puback(0x0777, 0, invalid_topic_id));
    robot.says(publish(qos1, 0x0777, 9, "x"));
    robot.hears(puback(0x0777, 9, invalid_topic_id));
    robot.says(publish(qos2, 0x0777, 10, "x"));
    robot.hears(puback(0x0777, 10, invalid_topic_id));  // and ends the exchange
}

TEST_P(S6_6_Publish, b_AnUnknownPredefinedIdIsAnsweredByPuback) {  // 6.7
    Client& robot = connected();
    robot.says(publish(qos1 | predefined, 0x7777, 9, "x"));
    robot.hears(puback(0x7777, 9, invalid_topic_id));
}

TEST_P(S6_6_Publish, b_TheReservedTypeOfTopicIdIsRefused) {
    Client& robot = connected();
    robot.says(publish(qos1 | reserved_type, 1, 9, "x"));
    robot.hears(puback(1, 9, not_supported));
}

TEST_P(S6_6_Publish, b_AShortNameWithWildcardsIsRefused) {
    Client& robot = connected();
    for (const std::string_view name : {"/#", "+/", "a+"}) {
        robot.says(publish(qos1 | short_name, short_topic(name), 9, "x"));
        robot.hears(puback(short_topic(name), 9, not_supported));
    }
}

TEST_P(S6_6_Publish, d_ARepeatedQos2PublishIsAnsweredAndHandedOnOnce) {
    Client& robot = connected();
    Client& watcher = connected();
    const unsigned at_watcher = watcher.subscribes(topic());
    const unsigned id = robot.registers(topic());
    robot.says(publish(qos2, id, 9, "x"));
    robot.hears(pubrec(9));
    robot.says(publish(dup | qos2, id, 9, "x"));
    robot.hears(pubrec(9));
    robot.says(publish(qos2, id, 9, "x"));  // emcute and asymcute repeat with DUP 0
    robot.hears(pubrec(9));
    watcher.hears_publish(no_flags, at_watcher, "x");
    hears_nothing(watcher);
}

TEST_P(S6_6_Publish, d_ARepeatedPubrelIsAnsweredAgain) {
    Client& robot = connected();
    robot.publishes(robot.registers(topic()), "x", 2);
    const unsigned last = robot.next_msg_id() - 1;
    robot.says(pubrel(last));
    robot.hears(pubcomp(last));
}

TEST_P(S6_6_Publish, d_APubrelOfAnUnknownMsgIdIsAnswered) {
    Client& robot = connected();
    robot.says(pubrel(0x4321));
    robot.hears(pubcomp(0x4321));
}

TEST_P(S6_6_Publish, d_AfterPubrelTheMsgIdIsFree) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic());
    for (const std::string data : {"x", "y"}) {
        robot.says(publish(qos2, id, 9, data));
        robot.hears(pubrec(9));
        robot.hears_publish(no_flags, id, data);
        robot.says(pubrel(9));
        robot.hears(pubcomp(9));
    }
}

TEST_P(S6_6_Publish, c_Qos0MayGoBetween) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic());
    robot.says(publish(qos2, id, 9, "2"));
    robot.hears(pubrec(9));
    robot.hears_publish(no_flags, id, "2");
    robot.says(publish(no_flags, id, 0, "0"));
    robot.hears_publish(no_flags, id, "0");
    robot.says(pubrel(9));
    robot.hears(pubcomp(9));
}

TEST_P(S6_6_Publish, DupIsNoReasonToDrop) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic());
    robot.says(publish(dup | qos1, id, 9, "x"));
    robot.hears(puback(id, 9));
    robot.hears_publish(no_flags, id, "x");
    robot.says(publish(dup | qos2, id, 10, "y"));
    robot.hears(pubrec(10));
    robot.hears_publish(no_flags, id, "y");
}

TEST_P(S6_6_Publish, g12_PubackComesBeforeThePublishersOwnCopy) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 1);
    robot.says(publish(qos1, id, 9, "x"));
    robot.hears(puback(id, 9));
    robot.takes(qos1, id, "x");
}

TEST_P(S6_6_Publish, g23_Qos0WithAMsgIdIsTaken) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic());
    robot.says(publish(no_flags, id, 0x1234, "x"));
    robot.hears_publish(no_flags, id, "x");
}

TEST_P(S6_6_Publish, g23_MsgId0IsCopied) {
    Client& robot = connected();
    const unsigned id = robot.registers(topic());
    robot.says(publish(qos1, id, 0, "x"));
    robot.hears(puback(id, 0));
    robot.says(publish(qos2, id, 0, "x"));
    robot.hears(pubrec(0));
    robot.says(pubrel(0));
    robot.hears(pubcomp(0));
}

TEST_P(S6_6_Publish, TopicsOfTheBrokerAreNotPublishedToByClients) {
    Client& robot = connected();
    const unsigned id = robot.registers("$SYS/conformance");
    robot.says(publish(qos1, id, 9, "x"));
    robot.hears(puback(id, 9, not_supported));
}

CONFORMANCE_SUITE(S6_7_TopicIds, PatientSuite);

TEST_P(S6_7_TopicIds, PredefinedIdsAreKnownToAllAtEveryQos) {
    Client& robot = connected();
    Client& watcher = connected();
    const unsigned id = agreement().predefined_id;
    watcher.says(subscribe_id(qos2, 5, id));
    watcher.hears(suback(qos2, id, 5));
    for (int qos = 0; qos <= 2; ++qos) {
        robot.publishes(id, "x", qos, predefined);
        watcher.takes(qos_flag(qos) | predefined, id, "x");
    }
}

TEST_P(S6_7_TopicIds, APredefinedIdIsItsTopicByAnotherName) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(agreement().predefined_topic);
    robot.publishes(agreement().predefined_id, "x", 1, predefined);
    robot.hears_publish(no_flags, id, "x");
}

TEST_P(S6_7_TopicIds, ShortNamesNeedNoRegistrationAtEveryQos) {
    Client& robot = connected();
    Client& watcher = connected();
    watcher.says(subscribe(qos2 | short_name, 5, "k1"));
    watcher.hears(suback(qos2, short_topic("k1"), 5));  // G17
    for (int qos = 0; qos <= 2; ++qos) {
        robot.publishes(short_topic("k1"), "x", qos, short_name);
        watcher.takes(qos_flag(qos) | short_name, short_topic("k1"), "x");
    }
}

TEST_P(S6_7_TopicIds, AShortNameIsTheTopicOfItsTwoCharacters) {
    Client& robot = connected();
    Client& watcher = connected();
    const unsigned id = robot.registers("k2");
    watcher.says(subscribe(short_name, 5, "k2"));
    watcher.hears(suback(no_flags, short_topic("k2"), 5));
    robot.publishes(id, "x");
    watcher.hears_publish(short_name, short_topic("k2"), "x");
}

TEST_P(S6_7_TopicIds, g17_ATwoOctetNameSubscribedAsANameIsDeliveredByItsId) {
    Client& robot = connected();
    const unsigned id = robot.subscribes("k3");
    EXPECT_NE(id, 0u);
    robot.publishes(short_topic("k3"), "x", 0, short_name);
    robot.hears_publish(no_flags, id, "x");
}

CONFORMANCE_SUITE(S6_8_QosMinus1, PatientSuite);

TEST_P(S6_8_QosMinus1, a_NeedsNoSession) {
    Client& watcher = connected();
    watcher.says(subscribe_id(qos1, 5, agreement().predefined_id));
    watcher.hears(suback(qos1, agreement().predefined_id, 5));
    watcher.says(subscribe(qos1 | short_name, 6, "m1"));
    watcher.hears(suback(qos1, short_topic("m1"), 6));
    Client& stranger = client();
    stranger.says(publish(qos_minus_1 | predefined, agreement().predefined_id, 0, "x"));
    watcher.hears_publish(predefined, agreement().predefined_id, "x");  // as QoS 0
    stranger.says(publish(qos_minus_1 | short_name, short_topic("m1"), 0, "y"));
    watcher.hears_publish(short_name, short_topic("m1"), "y");
    hears_nothing(stranger);
}

TEST_P(S6_8_QosMinus1, a_IsTakenFromAConnectedClientAsWell) {
    Client& robot = connected();
    robot.says(subscribe(short_name, 6, "m2"));
    robot.hears(suback(no_flags, short_topic("m2"), 6));
    robot.says(publish(qos_minus_1 | short_name, short_topic("m2"), 0, "y"));
    robot.hears_publish(short_name, short_topic("m2"), "y");
}

TEST_P(S6_8_QosMinus1, a_IsNeverAnswered) {
    Client& stranger = client();
    Client& robot = connected();
    for (Client* one : {&stranger, &robot}) {
        one->says(publish(qos_minus_1 | predefined, 0x7777, 0, "x"));
        one->says(publish(qos_minus_1 | short_name, short_topic("a#"), 0, "x"));
        one->says(publish(qos_minus_1 | reserved_type, 1, 0, "x"));
        one->says(publish(qos_minus_1, 0xFFFF, 0, "x"));
        hears_nothing(*one);
    }
}

TEST_P(S6_8_QosMinus1, g19_RetainIsHonoured) {
    Client& stranger = client();
    forget_retained("m3");
    stranger.says(publish(qos_minus_1 | short_name | retain, short_topic("m3"), 0, "kept"));
    Client& robot = connected();
    robot.says(subscribe(short_name, 6, "m3"));
    robot.hears(suback(no_flags, short_topic("m3"), 6));
    robot.hears_publish(short_name | retain, short_topic("m3"), "kept");
}

TEST_P(S6_8_QosMinus1, g19_TheFormOfRsmbAndPahoIsTaken) {
    Client& watcher = connected();
    const unsigned id = watcher.subscribes(topic());
    Client& stranger = client();
    const auto length = static_cast<unsigned>(topic().size());
    stranger.says(publish(qos_minus_1, length, 0, topic() + "data"));
    watcher.hears_publish(no_flags, id, "data");
}

}  // namespace
}  // namespace romano::conformance::publish_test
