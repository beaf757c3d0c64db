// MQTT-SN 1.2 sections 6.6 and 6.8: publish, client to broker.

#include <gtest/gtest.h>

#include <string>

#include "tests/romano/client/exchange.h"
#include "tests/romano/client/sequence_chart.h"

namespace romano::client::publishing_test {
namespace {

using namespace mqttsn;
using enum ReturnCode;

constexpr TopicId pose{5};

class Publishing : public testing::Test {
protected:
    void SetUp() override {
        chart.connect();
        chart.register_name("pose", pose);  // operation 1, message id 1
    }
    SequenceChart chart;
};

TEST_F(Publishing, AtQos0HasNoMsgIdAndNoAnswer) {
    chart.publish(topic_name("pose"), "x", qos0);
    chart.sends(publish_of(qos0, pose, no_msg_id, "x"));
    chart.tells("published 2");
    chart.after(5 * t_retry);
}

TEST_F(Publishing, AtQos1EndsWithPuback) {
    chart.publish(topic_name("pose"), "x", qos1);
    chart.sends(publish_of(qos1, pose, MsgId{2}, "x"));
    chart.gets(Puback{pose, MsgId{2}, accepted});
    chart.tells("published 2");
    chart.after(5 * t_retry);
}

TEST_F(Publishing, AtQos1IsSentAgainWithDupWhenPublishOrPubackIsLost) {
    chart.publish(topic_name("pose"), "x", qos1);
    chart.sends(publish_of(qos1, pose, MsgId{2}, "x"));
    chart.after(t_retry);
    chart.sends(again(publish_of(qos1, pose, MsgId{2}, "x")));
    chart.gets(Puback{pose, MsgId{2}, accepted});
    chart.tells("published 2");
}

TEST_F(Publishing, AtQos2IsPubrecPubrelPubcomp) {
    chart.publish(topic_name("pose"), "x", qos2);
    chart.sends(publish_of(qos2, pose, MsgId{2}, "x"));
    chart.gets(Pubrec{MsgId{2}});
    chart.sends(Pubrel{MsgId{2}});
    chart.gets(Pubcomp{MsgId{2}});
    chart.tells("published 2");
    chart.after(5 * t_retry);
}

TEST_F(Publishing, AtQos2SendsPublishAgainWhenItOrPubrecIsLost) {
    chart.publish(topic_name("pose"), "x", qos2);
    chart.sends(publish_of(qos2, pose, MsgId{2}, "x"));
    chart.after(t_retry);
    chart.sends(again(publish_of(qos2, pose, MsgId{2}, "x")));
    chart.gets(Pubrec{MsgId{2}});
    chart.sends(Pubrel{MsgId{2}});
    chart.gets(Pubcomp{MsgId{2}});
    chart.tells("published 2");
}

TEST_F(Publishing, AtQos2SendsPubrelAgainWhenItOrPubcompIsLost) {
    chart.publish(topic_name("pose"), "x", qos2);
    chart.sends(publish_of(qos2, pose, MsgId{2}, "x"));
    chart.gets(Pubrec{MsgId{2}});
    chart.sends(Pubrel{MsgId{2}});
    chart.after(t_retry);
    chart.sends(Pubrel{MsgId{2}});
    chart.gets(Pubcomp{MsgId{2}});
    chart.tells("published 2");
}

TEST_F(Publishing, GivesUpTheBrokerAfterNretryRepetitions) {  // 6.13
    chart.publish(topic_name("pose"), "x", qos1);
    chart.sends(publish_of(qos1, pose, MsgId{2}, "x"));
    for (int repetition = 0; repetition < n_retry; ++repetition) {
        chart.after(t_retry);
        chart.sends(again(publish_of(qos1, pose, MsgId{2}, "x")));
    }
    chart.after(t_retry);
    chart.tells("lost");
}

TEST_F(Publishing, AtQos2SendsPubrelForEachPubrec) {
    chart.publish(topic_name("pose"), "x", qos2);
    chart.sends(publish_of(qos2, pose, MsgId{2}, "x"));
    chart.gets(Pubrec{MsgId{2}});
    chart.sends(Pubrel{MsgId{2}});
    chart.gets(Pubrec{MsgId{2}});
    chart.sends(Pubrel{MsgId{2}});
    chart.gets(Pubcomp{MsgId{2}});
    chart.tells("published 2");
    chart.gets(Pubcomp{MsgId{2}});
}

TEST_F(Publishing, AtQos2IsNotEndedByPuback0) {  // 6.6a
    chart.publish(topic_name("pose"), "x", qos2);
    chart.sends(publish_of(qos2, pose, MsgId{2}, "x"));
    chart.gets(Puback{pose, MsgId{2}, accepted});
    chart.gets(Pubrec{MsgId{2}});
    chart.sends(Pubrel{MsgId{2}});
}

TEST_F(Publishing, AtQos1IsNotEndedByPubrecOrPubcomp) {
    chart.publish(topic_name("pose"), "x", qos1);
    chart.sends(publish_of(qos1, pose, MsgId{2}, "x"));
    chart.gets(Pubrec{MsgId{2}});
    chart.gets(Pubcomp{MsgId{2}});
    chart.gets(Puback{pose, MsgId{2}, accepted});
    chart.tells("published 2");
}

TEST_F(Publishing, IgnoresTheAnswerToAnotherMessage) {
    chart.publish(topic_name("pose"), "x", qos1);
    chart.sends(publish_of(qos1, pose, MsgId{2}, "x"));
    chart.gets(Puback{pose, MsgId{1}, accepted});
}

TEST_F(Publishing, AcceptsAPubackThatDoesNotRepeatTheTopicId) {  // G22
    chart.publish(topic_name("pose"), "x", qos1);
    chart.sends(publish_of(qos1, pose, MsgId{2}, "x"));
    chart.gets(Puback{no_topic_id, MsgId{2}, accepted});
    chart.tells("published 2");
}

TEST_F(Publishing, HasOneExchangeOutstandingWithQos0InBetween) {  // 6.6c
    chart.publish(topic_name("pose"), "1", qos1);
    chart.publish(topic_name("pose"), "2", qos2);
    chart.publish(topic_name("pose"), "3", qos0);
    chart.sends(publish_of(qos1, pose, MsgId{2}, "1"));
    chart.sends(publish_of(qos0, pose, no_msg_id, "3"));
    chart.tells("published 4");
    chart.gets(Puback{pose, MsgId{2}, accepted});
    chart.tells("published 2");
    chart.sends(publish_of(qos2, pose, MsgId{3}, "2"));
}

TEST_F(Publishing, RegistersAnewAfterPuback2AndSendsANewMessage) {  // 6.6e
    for (const Qos qos : {qos1, qos2}) {
        SequenceChart fresh;
        fresh.connect();
        fresh.register_name("pose", pose);
        fresh.publish(topic_name("pose"), "x", qos);
        fresh.sends(publish_of(qos, pose, MsgId{2}, "x"));
        fresh.gets(Puback{pose, MsgId{2}, invalid_topic_id});
        fresh.sends(register_of("pose", MsgId{3}));
        fresh.gets(Regack{TopicId{8}, MsgId{3}, accepted});
        fresh.sends(publish_of(qos, TopicId{8}, MsgId{4}, "x"));
        fresh.gets(Puback{TopicId{8}, MsgId{4}, invalid_topic_id});
        fresh.tells("failed 2 code 2");
    }
}

TEST_F(Publishing, AfterPuback2AtQos0RegistersBeforeTheNextMessage) {
    chart.publish(topic_name("pose"), "x", qos0);
    chart.sends(publish_of(qos0, pose, no_msg_id, "x"));
    chart.tells("published 2");
    chart.gets(Puback{pose, no_msg_id, invalid_topic_id});
    chart.publish(topic_name("pose"), "y", qos0);
    chart.sends(register_of("pose", MsgId{2}));
}

TEST_F(Publishing, OnAPredefinedIdFailsByPuback2) {  // 6.7
    chart.publish(predefined_topic(TopicId{3}), "x", qos1);
    chart.sends(
        Publish{false, qos1, false, TopicIdType::predefined, TopicId{3}, MsgId{2}, as_octets("x")});
    chart.gets(Puback{TopicId{3}, MsgId{2}, invalid_topic_id});
    chart.tells("failed 2 code 2");
}

TEST_F(Publishing, PausesForTwaitAfterCongestionThenSendsTheMessageAnew) {  // 6.6e
    chart.publish(topic_name("pose"), "x", qos1);
    chart.sends(publish_of(qos1, pose, MsgId{2}, "x"));
    chart.gets(Puback{pose, MsgId{2}, congestion});
    chart.tells("congested");
    chart.publish(topic_name("pose"), "y", qos0);
    chart.after(t_wait - t_retry);
    chart.is_silent();
    chart.after(t_retry);
    chart.sends(publish_of(qos1, pose, MsgId{3}, "x"));
    chart.gets(Puback{pose, MsgId{3}, accepted});
    chart.tells("published 2");
    chart.sends(publish_of(qos0, pose, no_msg_id, "y"));
    chart.tells("published 3");
}

TEST_F(Publishing, FailsWhenNotSupported) {
    chart.publish(topic_name("pose"), "x", qos2);
    chart.sends(publish_of(qos2, pose, MsgId{2}, "x"));
    chart.gets(Puback{pose, MsgId{2}, not_supported});
    chart.tells("failed 2 code 3");
}

TEST_F(Publishing, CarriesRetain) {
    chart.publish(topic_name("pose"), "x", qos0, true);
    chart.sends(Publish{false, qos0, true, TopicIdType::normal, pose, no_msg_id, as_octets("x")});
    chart.tells("published 2");
}

TEST(PublishingWithoutConnection, NeedsAShortOrPredefinedTopic) {  // 6.8a
    SequenceChart chart;
    chart.publish(short_topic("ab"), "x", qos_minus1);
    chart.sends(Publish{false, qos_minus1, false, TopicIdType::short_name, TopicId{0x6162},
                        no_msg_id, as_octets("x")});
    chart.tells("published 1");
    chart.publish(predefined_topic(TopicId{3}), "x", qos_minus1);
    chart.sends(Publish{false, qos_minus1, false, TopicIdType::predefined, TopicId{3}, no_msg_id,
                        as_octets("x")});
    chart.tells("published 2");
    chart.call([](auto& client, auto now, auto& out) {
        const auto named = client.publish(now, topic_name("pose"), {}, {.qos = qos_minus1}, out);
        ASSERT_FALSE(named);
        EXPECT_EQ(named.error(), Refusal::invalid_topic);
    });
}

TEST_F(Publishing, RefusesWhatNoDatagramHolds) {
    chart.call([](auto& client, auto now, auto& out) {
        const std::string data(HostLimits::datagram_octets - 8, 'x');
        const auto topic = topic_name("pose");
        EXPECT_EQ(client.publish(now, topic, as_octets(data), {}, out).error(), Refusal::too_long);
        const auto fits = as_octets(data).subspan(1);
        EXPECT_TRUE(client.publish(now, topic, fits, {}, out));
        ASSERT_EQ(out.datagrams().size(), 1u);
        EXPECT_EQ(out.datagrams()[0].size(), HostLimits::datagram_octets);
        out.clear();
    });
}

TEST_F(Publishing, RefusesImpossibleTopics) {
    chart.call([](auto& client, auto now, auto& out) {
        for (const auto& topic :
             {topic_name(""), short_topic(""), short_topic("a"), short_topic("abc")}) {
            const auto refused = client.publish(now, topic, {}, {.qos = qos1}, out);
            ASSERT_FALSE(refused);
            EXPECT_EQ(refused.error(), Refusal::invalid_topic);
        }
    });
}

TEST_F(Publishing, RefusesMoreWhenTheQueueIsFull) {  // P8
    chart.publish(topic_name("pose"), "first", qos1);
    chart.sends(publish_of(qos1, pose, MsgId{2}, "first"));
    chart.call([](auto& client, auto now, auto& out) {
        const std::string data(1000, 'x');
        std::size_t taken = 0;
        while (client.publish(now, topic_name("pose"), as_octets(data), {.qos = qos1}, out)) {
            ++taken;
        }
        EXPECT_GE(taken, 7u);
        EXPECT_LT(taken * data.size(), HostLimits::queue_octets);
        const auto refused = client.publish(now, topic_name("pose"), as_octets(data), {qos1}, out);
        EXPECT_EQ(refused.error(), Refusal::queue_full);
    });
}

}  // namespace
}  // namespace romano::client::publishing_test
