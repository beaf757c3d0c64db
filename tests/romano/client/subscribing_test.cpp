// MQTT-SN 1.2 section 6.9: subscribe and unsubscribe.

#include <gtest/gtest.h>

#include "tests/romano/client/exchange.h"
#include "tests/romano/client/sequence_chart.h"

namespace romano::client::subscribing_test {
namespace {

using namespace mqttsn;
using enum ReturnCode;

class Subscribing : public testing::Test {
protected:
    void SetUp() override { chart.connect(); }
    void subscribes(const TopicRef& topic, Qos qos) {
        chart.call([&](auto& client, auto now, auto& out) {
            ASSERT_TRUE(client.subscribe(now, topic, qos, out));
        });
    }
    void unsubscribes(const TopicRef& topic) {
        chart.call([&](auto& client, auto now, auto& out) {
            ASSERT_TRUE(client.unsubscribe(now, topic, out));
        });
    }
    SequenceChart chart;
};

TEST_F(Subscribing, ToANameLearnsItsTopicId) {  // 6.9a
    subscribes(topic_name("pose"), qos1);
    chart.sends(subscribe_of("pose", qos1, MsgId{1}));
    chart.gets(Suback{qos1, TopicId{5}, MsgId{1}, accepted});
    chart.tells("subscribed 1 id 5 qos 1");
    chart.gets(publish_of(qos0, TopicId{5}, no_msg_id, "x"));
    chart.tells("received pose x qos 0");
    chart.publish(topic_name("pose"), "y", qos0);
    chart.sends(publish_of(qos0, TopicId{5}, no_msg_id, "y"));
    chart.tells("published 2");
}

TEST_F(Subscribing, IsRepeatedWithDupWhenItOrSubackIsLost) {
    subscribes(topic_name("pose"), qos1);
    chart.sends(subscribe_of("pose", qos1, MsgId{1}));
    chart.after(t_retry);
    auto message = subscribe_of("pose", qos1, MsgId{1});
    message.dup = true;
    chart.sends(message);
    chart.gets(Suback{qos0, TopicId{5}, MsgId{1}, accepted});
    chart.tells("subscribed 1 id 5 qos 0");
}

TEST_F(Subscribing, ToWildcardsLearnsNamesByRegister) {  // 6.9b, 6.10a
    subscribes(topic_name("robots/+/pose"), qos2);
    chart.sends(subscribe_of("robots/+/pose", qos2, MsgId{1}));
    chart.gets(Suback{qos2, no_topic_id, MsgId{1}, accepted});
    chart.tells("subscribed 1 id 0 qos 2");
    chart.gets(Register{TopicId{1}, MsgId{1}, "robots/7/pose"});
    chart.sends(Regack{TopicId{1}, MsgId{1}, accepted});
    chart.gets(publish_of(qos0, TopicId{1}, no_msg_id, "x"));
    chart.tells("received robots/7/pose x qos 0");
}

TEST_F(Subscribing, ToAPredefinedTopicIsByItsId) {  // 6.9c
    subscribes(predefined_topic(TopicId{3}), qos0);
    chart.sends(Subscribe{false, qos0, MsgId{1}, predefined_topic(TopicId{3})});
    chart.gets(Suback{qos0, TopicId{3}, MsgId{1}, accepted});
    chart.tells("subscribed 1 id 3 qos 0");
    chart.gets(Publish{false, qos0, false, TopicIdType::predefined, TopicId{3}, no_msg_id,
                       as_octets("x")});
    chart.tells("received predefined 3 x qos 0");
}

TEST_F(Subscribing, ToAShortNameIsByItsOctets) {  // 6.9d
    subscribes(short_topic("ab"), qos0);
    chart.sends(Subscribe{false, qos0, MsgId{1}, short_topic("ab")});
    chart.gets(Suback{qos0, TopicId{0x6162}, MsgId{1}, accepted});
    chart.tells("subscribed 1 id 24930 qos 0");
    chart.gets(Publish{false, qos0, false, TopicIdType::short_name, TopicId{0x6162}, no_msg_id,
                       as_octets("x")});
    chart.tells("received ab x qos 0");
}

TEST_F(Subscribing, RefusedFails) {  // 6.9e
    subscribes(topic_name("a#"), qos0);
    chart.sends(subscribe_of("a#", qos0, MsgId{1}));
    chart.gets(Suback{qos0, no_topic_id, MsgId{1}, not_supported});
    chart.tells("failed 1 code 3");
}

TEST_F(Subscribing, IsAskedAgainAfterTwaitWhenTheBrokerIsCongested) {
    subscribes(topic_name("pose"), qos0);
    chart.sends(subscribe_of("pose", qos0, MsgId{1}));
    chart.gets(Suback{qos0, no_topic_id, MsgId{1}, congestion});
    chart.tells("congested");
    chart.after(t_wait);
    chart.sends(subscribe_of("pose", qos0, MsgId{2}));
}

TEST_F(Subscribing, HasOneRequestOutstanding) {  // 6.9g
    subscribes(topic_name("a"), qos0);
    subscribes(topic_name("b"), qos0);
    unsubscribes(topic_name("a"));
    chart.sends(subscribe_of("a", qos0, MsgId{1}));
    chart.is_silent();
    chart.gets(Suback{qos0, TopicId{1}, MsgId{1}, accepted});
    chart.tells("subscribed 1 id 1 qos 0");
    chart.sends(subscribe_of("b", qos0, MsgId{2}));
    chart.gets(Suback{qos0, TopicId{2}, MsgId{2}, accepted});
    chart.tells("subscribed 2 id 2 qos 0");
    chart.sends(Unsubscribe{MsgId{3}, topic_name("a")});
}

TEST_F(Subscribing, EndsByUnsubscribeAndUnsuback) {  // 6.9h
    unsubscribes(topic_name("pose"));
    chart.sends(Unsubscribe{MsgId{1}, topic_name("pose")});
    chart.after(t_retry);
    chart.sends(Unsubscribe{MsgId{1}, topic_name("pose")});
    chart.gets(Unsuback{MsgId{1}});
    chart.tells("unsubscribed 1");
}

TEST_F(Subscribing, RefusesImpossibleTopics) {
    chart.call([](auto& client, auto now, auto& out) {
        for (const auto& topic : {topic_name(""), short_topic(""), short_topic("abc")}) {
            const auto refused = client.subscribe(now, topic, qos0, out);
            ASSERT_FALSE(refused);
            EXPECT_EQ(refused.error(), Refusal::invalid_topic);
        }
    });
}

}  // namespace
}  // namespace romano::client::subscribing_test
