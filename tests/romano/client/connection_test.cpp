// MQTT-SN 1.2 sections 6.2, 6.3, 6.12 and 6.13: connect, clean session, disconnect, gateway loss.

#include <gtest/gtest.h>

#include "tests/romano/client/exchange.h"
#include "tests/romano/client/sequence_chart.h"

namespace romano::client::connection_test {
namespace {

using namespace mqttsn;
using namespace std::chrono_literals;
using enum ReturnCode;

const Connect connect{false, true, protocol_id, 60, "c"};
const Connect connect_with_will{true, true, protocol_id, 60, "c"};
const Willtopic will_topic{qos1, true, "wills/c"};
const Willmsg will_message{as_octets("gone")};

void connects(SequenceChart& chart, const ConnectOptions& options = {.client_id = "c"}) {
    chart.call([&](auto& client, auto now, auto& out) { client.connect(now, options, out); });
}

void connects_with_will(SequenceChart& chart) {
    connects(chart, {.client_id = "c", .will = Will{"wills/c", as_octets("gone"), qos1, true}});
}

TEST(Connecting, IsConnectAndConnack) {
    SequenceChart chart;
    connects(chart);
    chart.sends(connect);
    EXPECT_EQ(chart.client().state(), State::connecting);
    chart.gets(Connack{accepted});
    chart.tells("connected");
    EXPECT_TRUE(chart.client().is_connected());
}

TEST(Connecting, RepeatsConnectWhenItOrConnackIsLost) {
    SequenceChart chart;
    connects(chart);
    chart.sends(connect);
    chart.after(t_retry);
    chart.sends(connect);
    chart.gets(Connack{accepted});
    chart.tells("connected");
}

TEST(Connecting, GivesUpAfterNretryRepetitions) {
    SequenceChart chart;
    connects(chart);
    for (int sent = 0; sent < 1 + n_retry; ++sent) {
        chart.sends(connect);
        chart.after(t_retry);
    }
    chart.tells("lost");
    EXPECT_EQ(chart.client().state(), State::disconnected);
    EXPECT_EQ(chart.client().next_wakeup(), never);
}

TEST(Connecting, WithAWillAnswersThePrompts) {
    SequenceChart chart;
    connects_with_will(chart);
    chart.sends(connect_with_will);
    chart.gets(Willtopicreq{});
    chart.sends(will_topic);
    chart.gets(Willmsgreq{});
    chart.sends(will_message);
    chart.gets(Connack{accepted});
    chart.tells("connected");
}

TEST(Connecting, RepeatsTheStepOfTheWillThatIsNotAnswered) {
    SequenceChart chart;
    connects_with_will(chart);
    chart.sends(connect_with_will);
    chart.after(t_retry);
    chart.sends(connect_with_will);
    chart.gets(Willtopicreq{});
    chart.sends(will_topic);
    chart.after(t_retry);
    chart.sends(will_topic);
    chart.gets(Willmsgreq{});
    chart.sends(will_message);
    chart.after(t_retry);
    chart.sends(will_message);
    chart.gets(Connack{accepted});
    chart.tells("connected");
}

TEST(Connecting, AnswersARepeatedPromptAgain) {  // 6.2d
    SequenceChart chart;
    connects_with_will(chart);
    chart.sends(connect_with_will);
    chart.gets(Willtopicreq{});
    chart.sends(will_topic);
    chart.gets(Willtopicreq{});
    chart.sends(will_topic);
    chart.gets(Willmsgreq{});
    chart.sends(will_message);
    chart.gets(Willmsgreq{});
    chart.sends(will_message);
    chart.gets(Connack{accepted});
    chart.tells("connected");
}

TEST(Connecting, WithoutAWillIgnoresPrompts) {
    SequenceChart chart;
    connects(chart);
    chart.sends(connect);
    chart.gets(Willtopicreq{});
    chart.gets(Willmsgreq{});
    EXPECT_EQ(chart.client().dropped(), 2u);
}

TEST(Connecting, TellsARefusal) {  // 6.2c
    SequenceChart chart;
    connects(chart);
    chart.sends(connect);
    chart.gets(Connack{congestion});
    chart.tells("refused 1");
    EXPECT_EQ(chart.client().state(), State::disconnected);
    chart.after(10 * t_retry);
}

TEST(Connecting, IgnoresASecondConnack) {
    SequenceChart chart;
    chart.connect();
    chart.gets(Connack{accepted});
    chart.gets(Connack{not_supported});
    EXPECT_TRUE(chart.client().is_connected());
}

TEST(Connecting, SendsNothingElseBeforeConnack) {  // 6.2e
    SequenceChart chart;
    connects(chart);
    chart.sends(connect);
    chart.publish(topic_name("pose"), "x", qos1);
    chart.publish(topic_name("pose"), "y", qos0);
    chart.gets(Connack{accepted});
    chart.tells("connected");
    chart.sends(register_of("pose", MsgId{1}));
}

TEST(CleanSession, ForgetsTopicIds) {  // 6.3
    SequenceChart chart;
    chart.connect();
    chart.register_name("pose", TopicId{5});
    chart.connect();
    chart.publish(topic_name("pose"), "x", qos0);
    chart.sends(register_of("pose", MsgId{2}));
}

TEST(KeptSession, KeepsTopicIds) {
    SequenceChart chart;
    chart.connect();
    chart.register_name("pose", TopicId{5});
    chart.connect({.client_id = "c", .clean_session = false, .keep_alive = 0s});
    chart.publish(topic_name("pose"), "x", qos0);
    chart.sends(publish_of(qos0, TopicId{5}, no_msg_id, "x"));
    chart.tells("published 2");
}

TEST(Disconnecting, IsAnsweredByDisconnect) {  // 6.12a
    SequenceChart chart;
    chart.connect();
    chart.call([](auto& client, auto now, auto& out) { client.disconnect(now, out); });
    chart.sends(Disconnect{false, 0});
    chart.gets(Disconnect{false, 0});
    chart.tells("disconnected");
}

TEST(Disconnecting, EndsAlsoWhenNobodyAnswers) {
    SequenceChart chart;
    chart.connect();
    chart.call([](auto& client, auto now, auto& out) { client.disconnect(now, out); });
    for (int sent = 0; sent < 1 + n_retry; ++sent) {
        chart.sends(Disconnect{false, 0});
        chart.after(t_retry);
    }
    chart.tells("disconnected");
}

TEST(Disconnecting, ByTheBrokerIsTold) {  // 6.12b
    SequenceChart chart;
    chart.connect();
    chart.gets(Disconnect{false, 0});
    chart.tells("disconnected by broker");
    EXPECT_EQ(chart.client().state(), State::disconnected);
}

TEST(Reconnecting, SendsTheOpenPublishAgainInAKeptSession) {
    SequenceChart chart;
    chart.connect({.client_id = "c", .clean_session = false, .keep_alive = 0s});
    chart.register_name("pose", TopicId{5});
    const auto message = publish_of(qos2, TopicId{5}, MsgId{2}, "x");
    chart.publish(topic_name("pose"), "x", qos2);
    chart.sends(message);
    for (int repetition = 0; repetition < n_retry; ++repetition) {
        chart.after(t_retry);
        chart.sends(again(message));
    }
    chart.after(t_retry);
    chart.tells("lost");
    chart.connect({.client_id = "c", .clean_session = false, .keep_alive = 0s});
    chart.sends(again(message));
    chart.gets(Pubrec{MsgId{2}});
    chart.sends(Pubrel{MsgId{2}});
    chart.gets(Disconnect{false, 0});
    chart.tells("disconnected by broker");
    chart.connect({.client_id = "c", .clean_session = false, .keep_alive = 0s});
    chart.sends(Pubrel{MsgId{2}});
    chart.gets(Pubcomp{MsgId{2}});
    chart.tells("published 2");
}

TEST(Reconnecting, BeginsTheOpenPublishAnewInACleanSession) {
    SequenceChart chart;
    chart.connect();
    chart.register_name("pose", TopicId{5});
    chart.publish(topic_name("pose"), "x", qos1);
    chart.sends(publish_of(qos1, TopicId{5}, MsgId{2}, "x"));
    chart.connect();
    chart.sends(register_of("pose", MsgId{3}));
    chart.gets(Regack{TopicId{7}, MsgId{3}, accepted});
    chart.sends(publish_of(qos1, TopicId{7}, MsgId{4}, "x"));
    chart.gets(Puback{TopicId{7}, MsgId{4}, accepted});
    chart.tells("published 2");
}

TEST(Disconnected, DropsWhatTheBrokerSends) {
    SequenceChart chart;
    chart.gets(publish_of(qos1, TopicId{5}, MsgId{1}, "x"));
    chart.gets(Register{TopicId{5}, MsgId{1}, "pose"});
    chart.gets(Pingreq{});
    chart.gets(Pubrel{MsgId{1}});
    EXPECT_EQ(chart.client().dropped(), 4u);
}

TEST(Disconnected, RefusesQos0AndKeepsQos1ForLater) {
    SequenceChart chart;
    chart.call([](auto& client, auto now, auto& out) {
        const auto lost = client.publish(now, topic_name("pose"), {}, {.qos = qos0}, out);
        ASSERT_FALSE(lost);
        EXPECT_EQ(lost.error(), Refusal::not_connected);
    });
    chart.publish(short_topic("ab"), "x", qos1);
    chart.connect();
    chart.sends(Publish{false, qos1, false, TopicIdType::short_name, TopicId{0x6162}, MsgId{1},
                        as_octets("x")});
}

}  // namespace
}  // namespace romano::client::connection_test
