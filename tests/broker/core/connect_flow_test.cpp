// Connecting: MQTT-SN 1.2 sections 6.2, 6.3, 6.4 and the choices G7, G11, G13, G14, G20.

#include <gtest/gtest.h>

#include <string>

#include "tests/broker/core/scripted_client.h"

namespace romano::broker::connect_flow_test {
namespace {

class Connecting : public ::testing::Test {
protected:
    void connects_with_will(ScriptedClient& client, bool clean, std::string_view topic,
                            std::string_view message, std::uint16_t keep_alive_s = 10) {
        client.says(client.connect(clean, keep_alive_s, true));
        client.hears<Willtopicreq>();
        client.says(Willtopic{Qos::at_least_once, false, topic});
        client.hears<Willmsgreq>();
        client.says(Willmsg{as_octets(message)});
        EXPECT_EQ(client.hears<Connack>().return_code, ReturnCode::accepted);
    }

    ScriptedBroker broker{logging_options()};
    ScriptedClient robot{broker, "robot"};
    ScriptedClient watcher{broker, "watcher"};
};

TEST_F(Connecting, WithoutWillIsAnsweredAtOnce) {  // 6.2a
    robot.says(robot.connect());
    EXPECT_EQ(robot.hears<Connack>().return_code, ReturnCode::accepted);
    EXPECT_EQ(broker.core.connected_count(), 1u);
}

TEST_F(Connecting, WithWillPromptsForTopicAndMessageFirst) {  // 6.2b
    robot.says(robot.connect(true, 10, true));
    robot.hears<Willtopicreq>();
    EXPECT_EQ(broker.core.connected_count(), 0u);
    robot.says(Willtopic{Qos::at_least_once, false, "gone"});
    robot.hears<Willmsgreq>();
    EXPECT_EQ(broker.core.connected_count(), 0u);
    robot.says(Willmsg{as_octets("robot")});
    EXPECT_EQ(robot.hears<Connack>().return_code, ReturnCode::accepted);
    EXPECT_EQ(broker.core.image("robot")->will->topic, "gone");
}

TEST_F(Connecting, WrongProtocolIdIsRefused) {  // 6.2c
    auto connect = robot.connect();
    connect.protocol_id = 2;
    robot.says(connect);
    EXPECT_EQ(robot.hears<Connack>().return_code, ReturnCode::not_supported);
    EXPECT_EQ(broker.core.session_count(), 0u);
}

TEST_F(Connecting, RefusalOfAWillConnectComesAfterWillmsg) {  // G13
    robot.says(robot.connect(true, 10, true));
    robot.hears<Willtopicreq>();
    robot.says(Willtopic{Qos::at_least_once, false, "a/#"});
    robot.hears<Willmsgreq>();
    robot.says(Willmsg{as_octets("x")});
    EXPECT_EQ(robot.hears<Connack>().return_code, ReturnCode::not_supported);
    EXPECT_EQ(broker.core.session_count(), 0u);
}

TEST_F(Connecting, FullTableIsAnsweredByCongestion) {  // 6.2c
    BrokerOptions options = plain_options();
    options.limits.sessions = 1;
    ScriptedBroker small{options};
    ScriptedClient first{small, "first"};
    ScriptedClient second{small, "second"};
    first.connects();
    second.says(second.connect());
    EXPECT_EQ(second.hears<Connack>().return_code, ReturnCode::congestion);
    EXPECT_EQ(small.dropped(Drop::no_room), 1u);
    first.says(Disconnect{});  // what a clean session leaves behind makes room
    second.connects();
}

TEST_F(Connecting, RepeatedMessageGetsTheSameAnswerAgain) {  // 6.2d
    robot.says(robot.connect(true, 10, true));
    robot.hears<Willtopicreq>();
    robot.says(robot.connect(true, 10, true));
    robot.hears<Willtopicreq>();
    robot.says(Willtopic{Qos::at_most_once, false, "gone"});
    robot.hears<Willmsgreq>();
    robot.says(Willtopic{Qos::at_most_once, false, "gone"});
    robot.hears<Willmsgreq>();
    robot.says(Willmsg{as_octets("robot")});
    robot.hears<Connack>();
    robot.says(Willmsg{as_octets("robot")});
    robot.hears<Connack>();
}

TEST_F(Connecting, WillMessagesWithoutPromptAreIgnored) {  // 6.2d
    robot.says(Willtopic{Qos::at_most_once, false, "gone"});
    robot.says(Willmsg{as_octets("robot")});
    robot.hears_nothing();
    EXPECT_EQ(broker.dropped(Drop::unexpected), 2u);
}

TEST_F(Connecting, IdenticalConnectBeforeAnythingElseIsARepetition) {  // G7
    robot.connects(false);
    const std::size_t events = broker.log.size();
    robot.connects(false);
    EXPECT_EQ(broker.log.size(), events);
}

TEST_F(Connecting, CleanSessionErasesAllOfTheOldSession) {  // 6.3
    connects_with_will(robot, false, "gone", "robot");
    const TopicId id = robot.registers("a");
    robot.subscribes("b");
    robot.connects(true);
    const auto image = *broker.core.image("robot");
    EXPECT_TRUE(image.subscriptions.empty());
    EXPECT_TRUE(image.topics.empty());
    EXPECT_FALSE(image.will);
    robot.says(Publish{false, Qos::at_least_once, false, TopicIdType::normal, id, MsgId{1}, {}});
    EXPECT_EQ(robot.hears<Puback>().return_code, ReturnCode::invalid_topic_id);
    broker.expects_mirror_to_agree();
}

TEST_F(Connecting, KeptSessionKeepsSubscriptionsIdsQueueAndWill) {  // 6.3
    connects_with_will(robot, false, "gone", "robot", 0);
    const TopicId id = robot.registers("a");
    const TopicId cmd = robot.subscribes("cmd");
    robot.says(Disconnect{});
    robot.hears<Disconnect>();
    watcher.connects();
    const TopicId at_watcher = watcher.registers("cmd");
    watcher.publishes(at_watcher, "0", Qos::at_most_once);
    watcher.publishes(at_watcher, "1", Qos::at_least_once);
    watcher.publishes(at_watcher, "2", Qos::exactly_once);
    robot.hears_nothing();
    robot.connects(false);
    EXPECT_EQ(broker.core.image("robot")->will->topic, "gone");
    EXPECT_EQ(robot.hears_register("cmd"), cmd);  // G14: ids never change, but are told again
    EXPECT_EQ(robot.hears_publish("1", Qos::at_least_once).topic, cmd);
    robot.hears_publish("2", Qos::exactly_once);
    robot.hears_nothing();  // QoS 0 is not kept
    EXPECT_EQ(robot.registers("a"), id);
    broker.expects_mirror_to_agree();
}

TEST_F(Connecting, ClientThatIgnoresRegisterIsPublishedToAllTheSame) {  // G14
    robot.connects(false);
    robot.subscribes("cmd/#");
    watcher.connects();
    const TopicId id = watcher.registers("cmd/1");
    watcher.publishes(id, "1", Qos::at_least_once);
    TopicId told = no_topic_id;
    for (int sending = 0; sending < 4; ++sending) {
        told = robot.hears<Register>().topic_id;
        robot.says(Pingreq{});
        robot.hears<Pingresp>();
        broker.waits(10s);
    }
    EXPECT_EQ(robot.hears_publish("1", Qos::at_least_once).topic, told);
    watcher.publishes(id, "2", Qos::at_least_once);
    robot.hears_publish("2", Qos::at_least_once);
    watcher.publishes(watcher.registers("cmd/2"), "3", Qos::at_least_once);
    robot.hears_publish("3", Qos::at_least_once);  // it will not be asked again
}

TEST_F(Connecting, RegisterHoldsUpForASecondWhatTheClientSubscribedToByName) {  // G14
    robot.connects(false);
    const TopicId cmd = robot.subscribes("cmd");
    robot.says(Pingreq{});
    robot.hears<Pingresp>();
    robot.connects(false);
    watcher.connects();
    watcher.publishes(watcher.registers("cmd"), "1", Qos::at_least_once);
    EXPECT_EQ(robot.hears<Register>().topic_id, cmd);
    broker.waits(1s);
    EXPECT_EQ(robot.hears_publish("1", Qos::at_least_once).topic, cmd);
}

TEST_F(Connecting, EmptyWilltopicDeletesTheStoredWill) {  // 6.3a
    connects_with_will(robot, false, "gone", "robot");
    robot.says(robot.connect(false, 10, true));
    robot.hears<Willtopicreq>();
    robot.says(Willtopic{Qos::at_most_once, false, {}});
    EXPECT_EQ(robot.hears<Connack>().return_code, ReturnCode::accepted);
    EXPECT_FALSE(broker.core.image("robot")->will);
    broker.expects_mirror_to_agree();
}

TEST_F(Connecting, WillIsPublishedOnceWhenTheClientIsLost) {  // 6.14, P7
    watcher.connects();
    watcher.subscribes("gone", Qos::at_least_once);
    connects_with_will(robot, false, "gone", "robot", 10);
    broker.waits(16s);
    watcher.hears_publish("robot", Qos::at_least_once);
    broker.waits(10min);
    watcher.hears_nothing();
    EXPECT_EQ(broker.core.image("robot")->header.state, SessionState::lost);
    robot.ignores_what_came();
    robot.says(Pingreq{});
    robot.hears<Disconnect>();  // 6.12: it must connect again
    broker.expects_mirror_to_agree();
}

TEST_F(Connecting, WillIsNotPublishedOnDisconnect) {  // 6.12a
    watcher.connects();
    watcher.subscribes("gone");
    connects_with_will(robot, false, "gone", "robot", 10);
    robot.says(Disconnect{});
    robot.hears<Disconnect>();
    broker.waits(1h);
    watcher.hears_nothing();
}

TEST_F(Connecting, WillUpdatesReplaceTopicAndMessageIndependently) {  // 6.4a
    connects_with_will(robot, false, "gone", "robot");
    robot.says(Willtopicupd{Qos::exactly_once, true, "lost"});
    EXPECT_EQ(robot.hears<Willtopicresp>().return_code, ReturnCode::accepted);
    EXPECT_EQ(broker.core.image("robot")->will,
              (Will{"lost", octets_of("robot"), Qos::exactly_once, true}));
    robot.says(Willmsgupd{as_octets("7")});
    EXPECT_EQ(robot.hears<Willmsgresp>().return_code, ReturnCode::accepted);
    EXPECT_EQ(broker.core.image("robot")->will,
              (Will{"lost", octets_of("7"), Qos::exactly_once, true}));
    broker.expects_mirror_to_agree();
}

TEST_F(Connecting, EmptyWilltopicupdDeletesTheWill) {  // 6.4b
    connects_with_will(robot, false, "gone", "robot");
    robot.says(Willtopicupd{Qos::at_most_once, false, {}});
    EXPECT_EQ(robot.hears<Willtopicresp>().return_code, ReturnCode::accepted);
    EXPECT_FALSE(broker.core.image("robot")->will);
    broker.expects_mirror_to_agree();
}

TEST_F(Connecting, WillMessageWithoutTopicIsStoredAndNotPublished) {  // 6.4b
    robot.connects(true, 10);
    robot.says(Willmsgupd{as_octets("x")});
    EXPECT_EQ(robot.hears<Willmsgresp>().return_code, ReturnCode::accepted);
    broker.waits(1min);
    EXPECT_EQ(broker.core.image("robot")->header.state, SessionState::lost);
}

TEST_F(Connecting, LongClientIdIsTakenAndATooLongOneRefused) {  // G20
    ScriptedClient longer{broker, std::string(64, 'x')};
    longer.connects();
    ScriptedClient too_long{broker, std::string(65, 'x')};
    too_long.says(too_long.connect());
    EXPECT_EQ(too_long.hears<Connack>().return_code, ReturnCode::not_supported);
}

TEST_F(Connecting, EmptyClientIdNamesTheSessionByItsAddress) {  // G20
    ScriptedClient anonymous{broker, ""};
    ScriptedClient other{broker, ""};
    anonymous.connects(true);
    other.connects(true);
    EXPECT_EQ(broker.core.session_count(), 2u);
    anonymous.says(anonymous.connect(false));
    EXPECT_EQ(anonymous.hears<Connack>().return_code, ReturnCode::not_supported);
}

TEST_F(Connecting, SameClientIdFromANewAddressMovesTheSession) {  // G7
    connects_with_will(robot, false, "gone", "robot", 0);
    robot.subscribes("cmd");
    watcher.connects();
    watcher.subscribes("gone");
    ScriptedClient moved{broker, "robot"};
    moved.connects(false);
    robot.hears_nothing();
    EXPECT_EQ(broker.core.session_count(), 2u);
    watcher.publishes(watcher.registers("cmd"), "go");
    robot.hears_nothing();
    EXPECT_EQ(moved.hears<Register>().topic_name, "cmd");
    watcher.hears_nothing();  // never the will for it
    broker.expects_mirror_to_agree();
}

TEST_F(Connecting, NewClientIdOnAKnownAddressTakesItOver) {  // G7
    robot.connects(true, 10);
    robot.subscribes("cmd");
    ScriptedClient other{broker, "other", robot.address.endpoint.port};
    other.connects();
    watcher.connects();
    watcher.publishes(watcher.registers("cmd"), "go");
    other.hears_nothing();
    broker.waits(16s);
    EXPECT_EQ(broker.core.image("robot")->header.state, SessionState::lost);
    EXPECT_EQ(broker.core.image("other")->header.state, SessionState::active);
    other.hears_nothing();
}

TEST_F(Connecting, CleanSessionIsKeptForAWhileAfterDisconnection) {  // G11
    robot.connects(true);
    robot.subscribes("cmd");
    robot.says(Disconnect{});
    robot.hears<Disconnect>();
    watcher.connects();
    watcher.publishes(watcher.registers("cmd"), "1", Qos::at_least_once);
    broker.waits(9min);
    robot.connects(false);
    EXPECT_EQ(broker.core.image("robot")->subscriptions.size(), 1u);
    EXPECT_TRUE(broker.core.image("robot")->deliveries.empty());  // queued nothing meanwhile
    robot.connects(true);
    robot.says(Disconnect{});
    broker.waits(11min);
    EXPECT_FALSE(broker.core.image("robot"));
    broker.expects_mirror_to_agree();
}

// It may have spoken to another broker meanwhile, beyond a cut (simulator, seed 937788).
TEST_F(Connecting, P2_WhatComesForACleanSessionThatWasLostWaits) {
    robot.connects(true, 10);
    robot.subscribes("cmd");
    watcher.connects();
    const TopicId topic = watcher.registers("cmd");
    broker.waits(16s);
    EXPECT_EQ(broker.core.image("robot")->header.state, SessionState::lost);
    watcher.publishes(topic, "1", Qos::at_least_once);
    robot.ignores_what_came();
    robot.connects(false);
    robot.hears_register("cmd");
    robot.hears_publish("1", Qos::at_least_once);
}

TEST_F(Connecting, PromptsThatAreNeverAnsweredAreForgotten) {
    robot.says(robot.connect(true, 10, true));
    robot.hears<Willtopicreq>();
    broker.waits(2min);
    robot.says(Willtopic{Qos::at_most_once, false, "gone"});
    robot.hears_nothing();
    EXPECT_EQ(broker.core.next_wakeup(), never);
}

TEST_F(Connecting, ConnackOfASessionWaitsForTheLog) {  // design: an effect the client can see
    robot.connects(false);
    EXPECT_EQ(broker.last_after, broker.core.last_seq());
    EXPECT_EQ(broker.last_after, 1u);
}

TEST_F(Connecting, WhileCongestedNothingIsPromised) {
    watcher.connects();
    const TopicId id = watcher.registers("a");
    broker.core.set_congested(true);
    robot.says(robot.connect());
    EXPECT_EQ(robot.hears<Connack>().return_code, ReturnCode::congestion);
    watcher.says(Publish{false, Qos::at_least_once, false, TopicIdType::normal, id, MsgId{5}, {}});
    EXPECT_EQ(watcher.hears<Puback>().return_code, ReturnCode::congestion);
    watcher.says(Subscribe{false, Qos::at_most_once, MsgId{6}, {TopicIdType::normal, "a", {}}});
    EXPECT_EQ(watcher.hears<Suback>().return_code, ReturnCode::congestion);
    watcher.publishes(id, "qos 0 goes on");
}

}  // namespace
}  // namespace romano::broker::connect_flow_test
