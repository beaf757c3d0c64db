// MQTT-SN 1.2 sections 6.6 and 6.8: publish, client to broker.

#include <gtest/gtest.h>

#include "tests/romano/client/sequence_chart.h"

namespace romano::client {
namespace {

using namespace mqttsn;
using enum ReturnCode;

constexpr Qos qos0 = Qos::at_most_once;
constexpr Qos qos1 = Qos::at_least_once;
constexpr Qos qos2 = Qos::exactly_once;
constexpr TopicId pose{5};

Publish publish(Qos qos, TopicId id, MsgId msg_id, std::string_view data, bool dup = false) {
    return {dup, qos, false, TopicIdType::normal, id, msg_id, as_octets(data)};
}

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
    chart.sends(publish(qos0, pose, no_msg_id, "x"));
    chart.tells("published 2");
    chart.after(5 * Tretry);
}

TEST_F(Publishing, AtQos1EndsWithPuback) {
    chart.publish(topic_name("pose"), "x", qos1);
    chart.sends(publish(qos1, pose, MsgId{2}, "x"));
    chart.gets(Puback{pose, MsgId{2}, accepted});
    chart.tells("published 2");
    chart.after(5 * Tretry);
}

TEST_F(Publishing, AtQos1IsSentAgainWithDupWhenPublishOrPubackIsLost) {
    chart.publish(topic_name("pose"), "x", qos1);
    chart.sends(publish(qos1, pose, MsgId{2}, "x"));
    chart.after(Tretry);
    chart.sends(publish(qos1, pose, MsgId{2}, "x", true));
    chart.gets(Puback{pose, MsgId{2}, accepted});
    chart.tells("published 2");
}

TEST_F(Publishing, AtQos2IsPubrecPubrelPubcomp) {
    chart.publish(topic_name("pose"), "x", qos2);
    chart.sends(publish(qos2, pose, MsgId{2}, "x"));
    chart.gets(Pubrec{MsgId{2}});
    chart.sends(Pubrel{MsgId{2}});
    chart.gets(Pubcomp{MsgId{2}});
    chart.tells("published 2");
    chart.after(5 * Tretry);
}

TEST_F(Publishing, AtQos2SendsPublishAgainWhenItOrPubrecIsLost) {
    chart.publish(topic_name("pose"), "x", qos2);
    chart.sends(publish(qos2, pose, MsgId{2}, "x"));
    chart.after(Tretry);
    chart.sends(publish(qos2, pose, MsgId{2}, "x", true));
    chart.gets(Pubrec{MsgId{2}});
    chart.sends(Pubrel{MsgId{2}});
    chart.gets(Pubcomp{MsgId{2}});
    chart.tells("published 2");
}

TEST_F(Publishing, AtQos2SendsPubrelAgainWhenItOrPubcompIsLost) {
    chart.publish(topic_name("pose"), "x", qos2);
    chart.sends(publish(qos2, pose, MsgId{2}, "x"));
    chart.gets(Pubrec{MsgId{2}});
    chart.sends(Pubrel{MsgId{2}});
    chart.after(Tretry);
    chart.sends(Pubrel{MsgId{2}});
    chart.gets(Pubcomp{MsgId{2}});
    chart.tells("published 2");
}

}  // namespace
}  // namespace romano::client
