// MQTT-SN 1.2 section 6.11: keep-alive.

#include <gtest/gtest.h>

#include "tests/romano/client/exchange.h"
#include "tests/romano/client/sequence_chart.h"

namespace romano::client::keep_alive_test {
namespace {

using namespace mqttsn;
using namespace std::chrono_literals;
using enum ReturnCode;

const ConnectOptions every_60_s{.client_id = "c", .keep_alive = 60s};

TEST(KeepAlive, PingsWithinEachPeriod) {
    SequenceChart chart;
    chart.connect(every_60_s);
    for (int period = 0; period < 3; ++period) {
        chart.after(44s);
        chart.is_silent();
        chart.after(1s);
        chart.sends(Pingreq{});
        chart.gets(Pingresp{});
    }
}

TEST(KeepAlive, RepeatsAPingThatIsNotAnswered) {
    SequenceChart chart;
    chart.connect(every_60_s);
    chart.after(45s);
    chart.sends(Pingreq{});
    chart.after(t_retry);
    chart.sends(Pingreq{});
    chart.gets(Pingresp{});
    chart.after(44s);
}

TEST(KeepAlive, LosesTheBrokerAfterNretryPings) {  // 6.13a
    SequenceChart chart;
    chart.connect(every_60_s);
    chart.after(45s);
    for (int sent = 0; sent < 1 + n_retry; ++sent) {
        chart.sends(Pingreq{});
        chart.after(t_retry);
    }
    chart.tells("lost");
    EXPECT_EQ(chart.client().next_wakeup(), never);
}

TEST(KeepAlive, TakesAnyAnsweredRequestForAPing) {
    SequenceChart chart;
    chart.connect(every_60_s);
    chart.after(40s);
    chart.publish(short_topic("ab"), "x", qos1);
    chart.sends(Publish{false, qos1, false, TopicIdType::short_name, TopicId{0x6162}, MsgId{1},
                        as_octets("x")});
    chart.gets(Puback{TopicId{0x6162}, MsgId{1}, accepted});
    chart.tells("published 1");
    chart.after(44s);
    chart.is_silent();
    chart.after(1s);
    chart.sends(Pingreq{});
}

TEST(KeepAlive, PingsAlthoughMessagesAtQos0AreSentThatNobodyAnswers) {
    SequenceChart chart;
    chart.connect(every_60_s);
    chart.after(40s);
    chart.publish(short_topic("ab"), "x", qos0);
    chart.sends(Publish{false, qos0, false, TopicIdType::short_name, TopicId{0x6162}, no_msg_id,
                        as_octets("x")});
    chart.tells("published 1");
    chart.after(5s);
    chart.sends(Pingreq{});
}

TEST(KeepAlive, PingsBesideAnOutstandingExchange) {
    SequenceChart chart({.t_retry = 20s, .n_retry = 9});
    chart.connect(every_60_s);
    chart.after(40s);
    chart.publish(short_topic("ab"), "x", qos1);
    const Publish message{false,           qos1,     false,         TopicIdType::short_name,
                          TopicId{0x6162}, MsgId{1}, as_octets("x")};
    chart.sends(message);
    chart.after(5s);
    chart.sends(Pingreq{});
    chart.gets(Pingresp{});
    chart.after(15s);
    chart.sends(again(message));
}

TEST(KeepAlive, OfZeroNeverPings) {
    SequenceChart chart;
    chart.connect({.client_id = "c", .keep_alive = 0s});
    EXPECT_EQ(chart.client().next_wakeup(), never);
}

TEST(KeepAlive, PingsAtOnceWhenTheOwnerTalksToAnotherBroker) {
    SequenceChart chart;
    chart.connect({.client_id = "c", .keep_alive = 0s});
    chart.client().on_broker_changed(chart.now());
    chart.after(0s);
    chart.sends(Pingreq{});
    chart.gets(Pingresp{});
    EXPECT_EQ(chart.client().next_wakeup(), never);
}

TEST(KeepAlive, AsksAnotherBrokerAtOnceWhatTheFormerHasNotAnswered) {
    SequenceChart chart;
    chart.connect({.client_id = "c", .keep_alive = 0s});
    chart.register_name("pose", TopicId{7});
    chart.publish(topic_name("pose"), "x=1", Qos::exactly_once);
    chart.sends(Publish{false, Qos::exactly_once, false, TopicIdType::normal, TopicId{7}, MsgId{2},
                        as_octets("x=1")});
    chart.gets(Pubrec{MsgId{2}});
    chart.sends(Pubrel{MsgId{2}});
    for (int repetition = 0; repetition < n_retry; ++repetition) {
        chart.after(t_retry);
        chart.sends(Pubrel{MsgId{2}});
    }
    chart.client().on_broker_changed(chart.now());
    chart.after(0s);
    chart.sends(Pubrel{MsgId{2}});
    chart.sends(Pingreq{});
    chart.gets(Pubcomp{MsgId{2}});
    chart.tells("published 2");
    chart.gets(Pingresp{});
    EXPECT_EQ(chart.client().next_wakeup(), never);
}

TEST(KeepAlive, PingsOnceWhenTheOwnerWantsToHearOfTheBroker) {
    SequenceChart chart;
    chart.connect({.client_id = "c", .keep_alive = 0s});
    chart.client().probe(chart.now());
    chart.after(0s);
    chart.sends(Pingreq{});
    chart.client().probe(chart.now());
    chart.after(1s);
    chart.gets(Pingresp{});
    EXPECT_EQ(chart.client().next_wakeup(), never);
}

TEST(KeepAlive, AnswersTheBrokersPing) {  // 6.11b
    SequenceChart chart;
    chart.connect(every_60_s);
    chart.gets(Pingreq{});
    chart.sends(Pingresp{});
}

}  // namespace
}  // namespace romano::client::keep_alive_test
