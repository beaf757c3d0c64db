// REGISTER, SUBSCRIBE, UNSUBSCRIBE: MQTT-SN 1.2 sections 6.5, 6.9 and the choices G15, G17, G18.

#include <gtest/gtest.h>

#include <string>

#include "tests/broker/core/scripted_client.h"

namespace romano::broker::subscribe_flow_test {
namespace {

class Subscribing : public ::testing::Test {
protected:
    Subscribing() {
        robot.connects();
        publisher.connects();
    }

    Suback subscribes(TopicRef topic, Qos qos = Qos::at_least_once) {
        robot.says(Subscribe{false, qos, MsgId{77}, topic});
        const auto ack = robot.hears<Suback>();
        EXPECT_EQ(ack.msg_id, MsgId{77});
        return ack;
    }

    ScriptedBroker broker{logging_options()};
    ScriptedClient robot{broker, "robot"};
    ScriptedClient publisher{broker, "publisher"};
};

TEST_F(Subscribing, OneNameHasOneIdCountedUpFromOne) {  // 6.5a, G15
    EXPECT_EQ(robot.registers("a"), TopicId{1});
    EXPECT_EQ(robot.registers("b"), TopicId{2});
    EXPECT_EQ(robot.registers("a"), TopicId{1});
    EXPECT_EQ(robot.subscribes("b"), TopicId{2});
    EXPECT_EQ(robot.subscribes("c"), TopicId{3});
}

TEST_F(Subscribing, RegisterOfNoValidNameIsRefused) {  // 6.5b
    for (const std::string& name : {std::string{}, std::string{"a/+"}, std::string{"#"},
                                    std::string{"\xFF"}, std::string{"a\0b", 3}}) {
        robot.says(Register{no_topic_id, MsgId{5}, name});
        const auto ack = robot.hears<Regack>();
        EXPECT_EQ(ack.return_code, ReturnCode::not_supported) << name;
        EXPECT_EQ(ack.topic_id, no_topic_id);
        EXPECT_EQ(ack.msg_id, MsgId{5});
    }
}

TEST_F(Subscribing, FullTopicTableIsAnsweredByCongestion) {  // 6.5b, 6.9e
    BrokerOptions options = plain_options();
    options.limits.topics_per_session = 1;
    options.limits.subscriptions_per_session = 1;
    ScriptedBroker small{options};
    ScriptedClient client{small, "client"};
    client.connects();
    client.registers("a");
    client.says(Register{no_topic_id, MsgId{1}, "b"});
    EXPECT_EQ(client.hears<Regack>().return_code, ReturnCode::congestion);
    client.subscribes("a");
    client.says(Subscribe{false, Qos::at_most_once, MsgId{2}, {TopicIdType::normal, "#", {}}});
    EXPECT_EQ(client.hears<Suback>().return_code, ReturnCode::congestion);
    client.subscribes("a", Qos::at_most_once);  // a replacement takes no room
}

TEST_F(Subscribing, WildcardIsAcknowledgedWithTopicIdZero) {  // 6.9b
    EXPECT_EQ(subscribes({TopicIdType::normal, "a/#", {}}).topic_id, no_topic_id);
}

TEST_F(Subscribing, PredefinedIsDeliveredAsPredefined) {  // 6.9c
    EXPECT_EQ(subscribes({TopicIdType::predefined, {}, TopicId{7}}).topic_id, TopicId{7});
    publisher.publishes(publisher.registers("predefined/seven"), "x");
    const auto publish = robot.hears_publish("x");
    EXPECT_EQ(publish.topic_type, TopicIdType::predefined);
    EXPECT_EQ(publish.topic, TopicId{7});
}

TEST_F(Subscribing, UnknownPredefinedIsRefused) {  // 6.9c
    const auto ack = subscribes({TopicIdType::predefined, {}, TopicId{8}});
    EXPECT_EQ(ack.return_code, ReturnCode::invalid_topic_id);
    EXPECT_EQ(ack.topic_id, TopicId{8});
}

TEST_F(Subscribing, ShortNameIsDeliveredAsShortName) {  // 6.9d, G17
    EXPECT_EQ(subscribes({TopicIdType::short_name, "ab", {}}).topic_id, TopicId{0x6162});
    publisher.publishes(publisher.registers("ab"), "x");
    const auto publish = robot.hears_publish("x");
    EXPECT_EQ(publish.topic_type, TopicIdType::short_name);
    EXPECT_EQ(publish.topic, TopicId{0x6162});
}

TEST_F(Subscribing, TwoOctetNameOfTypeNormalIsDeliveredAsNormal) {  // G17
    const TopicId id = subscribes({TopicIdType::normal, "ab", {}}).topic_id;
    publisher.publishes(publisher.registers("ab"), "x");
    const auto publish = robot.hears_publish("x");
    EXPECT_EQ(publish.topic_type, TopicIdType::normal);
    EXPECT_EQ(publish.topic, id);
}

TEST_F(Subscribing, OddShortNamesAreFilters) {  // G18
    EXPECT_EQ(subscribes({TopicIdType::short_name, "#", {}}).return_code, ReturnCode::accepted);
    publisher.publishes(publisher.registers("xy"), "x");
    robot.hears_publish("x");
    EXPECT_EQ(subscribes({TopicIdType::short_name, "/#", {}}).return_code, ReturnCode::accepted);
}

TEST_F(Subscribing, InvalidRequestsAreRefused) {  // 6.9e
    EXPECT_EQ(subscribes({TopicIdType::normal, "a#", {}}).return_code, ReturnCode::not_supported);
    EXPECT_EQ(subscribes({TopicIdType::normal, "a", {}}, Qos::without_connection).return_code,
              ReturnCode::not_supported);
    EXPECT_EQ(subscribes({TopicIdType::reserved, "a", {}}).return_code, ReturnCode::not_supported);
    EXPECT_TRUE(broker.core.image("robot")->subscriptions.empty());
}

TEST_F(Subscribing, EveryQosIsGrantedAsWanted) {  // 6.9e
    EXPECT_EQ(subscribes({TopicIdType::normal, "a", {}}, Qos::exactly_once).qos, Qos::exactly_once);
    EXPECT_EQ(subscribes({TopicIdType::normal, "a", {}}, Qos::at_most_once).qos, Qos::at_most_once);
}

TEST_F(Subscribing, SameFilterAgainReplacesTheSubscription) {  // 6.9f
    robot.subscribes("a", Qos::exactly_once);
    robot.subscribes("a", Qos::at_most_once);
    publisher.publishes(publisher.registers("a"), "x", Qos::exactly_once);
    robot.hears_publish("x", Qos::at_most_once);
    robot.hears_nothing();
    EXPECT_EQ(broker.core.image("robot")->subscriptions.size(), 1u);
    broker.expects_mirror_to_agree();
}

TEST_F(Subscribing, RefusalsPromiseNothingAndWaitForNoEvent) {
    publisher.registers("a");  // later than the last promise to the robot
    broker.core.set_congested(true);
    EXPECT_EQ(subscribes({TopicIdType::normal, "a", {}}).return_code, ReturnCode::congestion);
    EXPECT_LT(broker.last_after, broker.core.last_seq());
    broker.core.set_congested(false);
    EXPECT_EQ(subscribes({TopicIdType::normal, "#/a", {}}).return_code, ReturnCode::not_supported);
    EXPECT_LT(broker.last_after, broker.core.last_seq());
    robot.says(Register{no_topic_id, MsgId{1}, "a/#"});
    EXPECT_EQ(robot.hears<Regack>().return_code, ReturnCode::not_supported);
    EXPECT_LT(broker.last_after, broker.core.last_seq());
    subscribes({TopicIdType::normal, "a", {}});
    EXPECT_EQ(broker.last_after, broker.core.last_seq());
}

TEST_F(Subscribing, UnsubscribeIsAlwaysAcknowledged) {  // 6.9h
    robot.says(Unsubscribe{MsgId{3}, {TopicIdType::normal, "never", {}}});
    EXPECT_EQ(robot.hears<Unsuback>().msg_id, MsgId{3});
    robot.says(Unsubscribe{MsgId{4}, {TopicIdType::normal, "a#", {}}});
    EXPECT_EQ(robot.hears<Unsuback>().msg_id, MsgId{4});
}

TEST_F(Subscribing, AfterUnsubscribeTheTopicIdStaysValidForPublishing) {  // 6.9h
    const TopicId id = robot.subscribes("a");
    robot.says(Unsubscribe{MsgId{3}, {TopicIdType::normal, "a", {}}});
    robot.hears<Unsuback>();
    robot.publishes(id, "x", Qos::at_least_once);
    robot.hears_nothing();
    broker.expects_mirror_to_agree();
}

TEST_F(Subscribing, OpenDeliveryEndsNormallyAfterUnsubscribe) {  // 6.9h
    robot.subscribes("a");
    publisher.publishes(publisher.registers("a"), "x", Qos::exactly_once);
    const MsgId msg_id = robot.hears<Publish>().msg_id;
    robot.says(Unsubscribe{MsgId{3}, {TopicIdType::normal, "a", {}}});
    robot.hears<Unsuback>();
    robot.says(Pubrec{msg_id});
    EXPECT_EQ(robot.hears<Pubrel>().msg_id, msg_id);
    robot.says(Pubcomp{msg_id});
    robot.hears_nothing();
}

TEST_F(Subscribing, WildcardsDoNotMatchDollarTopics) {  // G26, M-4.7.2-1
    robot.subscribes("#");
    publisher.publishes(publisher.registers("$internal/x"), "x");
    robot.hears_nothing();
}

}  // namespace
}  // namespace romano::broker::subscribe_flow_test
