// The way of messages through one broker: connect, register, subscribe, publish (MQTT-SN 1.2
// sections 6.2, 6.5, 6.6, 6.9, 6.10).

#include "broker/core/broker_core.h"

#include <gtest/gtest.h>

#include "tests/broker/core/scripted_client.h"

namespace romano::broker::broker_core_test {
namespace {

class Broker : public ::testing::Test {
protected:
    ScriptedBroker broker;
    ScriptedClient a{broker, "a"};
    ScriptedClient b{broker, "b"};
};

TEST_F(Broker, Qos0PublishReachesPlainSubscriber) {  // 6.6a, 6.10c
    a.connects();
    b.connects();
    const TopicId at_b = b.subscribes("pose");
    a.publishes(a.registers("pose"), "x=1");
    const auto publish = b.hears_publish("x=1");
    EXPECT_EQ(publish.topic, at_b);
    EXPECT_EQ(publish.topic_type, TopicIdType::normal);
    EXPECT_EQ(publish.msg_id, no_msg_id);
    EXPECT_FALSE(publish.retain);
    a.hears_nothing();
    b.hears_nothing();
}

TEST_F(Broker, Qos1AndQos2GoThroughBothWays) {  // 6.6a, 6.10d
    a.connects();
    b.connects();
    b.subscribes("pose");
    const TopicId id = a.registers("pose");
    a.publishes(id, "one", Qos::at_least_once);
    EXPECT_NE(b.hears_publish("one", Qos::at_least_once).msg_id, no_msg_id);
    a.publishes(id, "two", Qos::exactly_once);
    b.hears_publish("two", Qos::exactly_once);
    b.hears_nothing();
}

TEST_F(Broker, WildcardSubscriberIsToldTheNameFirst) {  // 6.9b, 6.10a
    a.connects();
    b.connects();
    EXPECT_EQ(b.subscribes("robot/+/pose"), no_topic_id);
    const TopicId id = a.registers("robot/7/pose");
    a.publishes(id, "1");
    a.publishes(id, "2");
    const auto told = b.hears<Register>();
    EXPECT_EQ(told.topic_name, "robot/7/pose");
    b.hears_nothing();
    b.says(Regack{told.topic_id, told.msg_id, ReturnCode::accepted});
    EXPECT_EQ(b.hears_publish("1").topic, told.topic_id);
    EXPECT_EQ(b.hears_publish("2").topic, told.topic_id);
    a.publishes(id, "3");
    b.hears_publish("3");
}

TEST_F(Broker, OneExchangeIsOpenPerClientAndTheRestWaitsInOrder) {  // G24
    a.connects();
    b.connects();
    b.subscribes("t");
    const TopicId id = a.registers("t");
    a.publishes(id, "1", Qos::at_least_once);
    a.publishes(id, "2", Qos::exactly_once);
    a.publishes(id, "3", Qos::at_least_once);
    EXPECT_EQ(b.unheard(), 1u);
    b.hears_publish("1", Qos::at_least_once);
    b.hears_publish("2", Qos::exactly_once);
    b.hears_publish("3", Qos::at_least_once);
    b.hears_nothing();
}

TEST_F(Broker, RetainedMessageComesAfterSuback) {  // G12
    a.connects();
    a.publishes(a.registers("map"), "grid", Qos::at_least_once, true);
    b.connects();
    b.subscribes("map");
    const auto publish = b.hears_publish("grid", Qos::at_least_once);
    EXPECT_TRUE(publish.retain);
    b.hears_nothing();
}

TEST_F(Broker, RetainedMessageStaysOneWhenItOvertookItsSuback) {  // G21
    ScriptedClient talker{broker, "talker"};
    talker.connects();
    talker.publishes(talker.registers("pose"), "x=1", Qos::at_least_once, true);
    ScriptedClient listener{broker, "listener"};
    listener.connects();
    listener.subscribes("pose", Qos::at_least_once);
    const auto unknown = listener.hears<Publish>();
    listener.says(Puback{unknown.topic, unknown.msg_id, ReturnCode::invalid_topic_id});
    listener.hears_register("pose");
    EXPECT_TRUE(listener.hears_publish("x=1", Qos::at_least_once).retain);
}

TEST_F(Broker, PublishAfterAnUnknownIdHasANewMessageIdAndNoDup) {  // 6.10e, G21
    a.connects();
    b.connects();
    b.subscribes("pose");
    a.publishes(a.registers("pose"), "x=1", Qos::at_least_once);
    const auto unknown = b.hears<Publish>();
    b.says(Puback{unknown.topic, unknown.msg_id, ReturnCode::invalid_topic_id});
    b.hears_register("pose");
    const auto second = b.hears<Publish>();
    EXPECT_FALSE(second.dup);
    EXPECT_NE(second.msg_id, unknown.msg_id);
    broker.waits(mqttsn::default_t_retry);
    EXPECT_TRUE(b.hears<Publish>().dup);
}

TEST_F(Broker, ClientThatIgnoresRegisterGetsWhatItSubscribedToByNameAfterASecond) {  // G14
    a.connects();
    b.connects(false);
    const TopicId at_b = b.subscribes("pose");
    b.says(Disconnect{});
    b.hears<Disconnect>();
    const TopicId at_a = a.registers("pose");
    a.publishes(at_a, "1", Qos::at_least_once);
    b.connects(false);
    EXPECT_EQ(b.hears<Register>().topic_id, at_b);
    broker.waits(999ms);
    b.hears_nothing();
    broker.waits(1ms);
    const auto publish = b.hears_publish("1", Qos::at_least_once);
    EXPECT_EQ(publish.topic, at_b);
    EXPECT_FALSE(publish.dup);
    a.publishes(at_a, "2", Qos::at_least_once);
    b.hears_publish("2", Qos::at_least_once);
}

TEST_F(Broker, SilentClientThatIgnoresRegisterGetsThePublishAfterAllRetries) {  // 6.10a, G14
    a.connects();
    b.connects();
    b.subscribes("robot/+");
    a.publishes(a.registers("robot/7"), "1", Qos::at_least_once);
    for (int sending = 0; sending <= mqttsn::default_n_retry; ++sending) {
        b.hears<Register>();
        b.hears_nothing();
        broker.waits(mqttsn::default_t_retry);
    }
    b.hears_publish("1", Qos::at_least_once);
}

TEST_F(Broker, AddressThatGotANewOwnerHearsNothingOfTheOldOne) {  // G7
    a.connects();
    b.connects();
    b.subscribes("pose");
    a.publishes(a.registers("pose"), "1", Qos::at_least_once);
    b.hears<Publish>();
    ScriptedClient next{broker, "next", b.address.endpoint.port};
    next.connects();
    broker.waits(2 * mqttsn::default_t_retry);
    next.hears_nothing();
    b.connects();
    b.hears_nothing();
}

TEST_F(Broker, PublisherHearsItsAnswerBeforeItsOwnCopy) {  // G12
    a.connects();
    const TopicId id = a.subscribes("echo", Qos::at_least_once);
    a.publishes(id, "hello", Qos::at_least_once);
    a.hears_publish("hello", Qos::at_least_once);
}

}  // namespace
}  // namespace romano::broker::broker_core_test
