// MQTT-SN 1.2 section 6.10, and 6.6 at QoS 2: messages from the broker.

#include <gtest/gtest.h>

#include "tests/romano/client/exchange.h"
#include "tests/romano/client/sequence_chart.h"

namespace romano::client::receiving_test {
namespace {

using namespace mqttsn;
using namespace std::chrono_literals;
using enum ReturnCode;

constexpr TopicId pose{5};

class Receiving : public testing::Test {
protected:
    void SetUp() override {
        chart.connect();
        chart.subscribe(topic_name("pose"), pose, qos2);
    }
    SequenceChart chart;
};

TEST_F(Receiving, AtQos0IsNotAnswered) {
    chart.gets(publish_of(qos0, pose, no_msg_id, "x"));
    chart.tells("received pose x qos 0");
}

TEST_F(Receiving, AtQos1IsAnsweredByPubackEachTime) {
    chart.gets(publish_of(qos1, pose, MsgId{7}, "x"));
    chart.sends(Puback{pose, MsgId{7}, accepted});
    chart.tells("received pose x qos 1");
    chart.gets(again(publish_of(qos1, pose, MsgId{7}, "x")));
    chart.sends(Puback{pose, MsgId{7}, accepted});
    chart.tells("received pose x qos 1 dup");
}

TEST_F(Receiving, AtQos2TellsTheMessageOnce) {
    const auto message = publish_of(qos2, pose, MsgId{7}, "x");
    chart.gets(message);
    chart.sends(Pubrec{MsgId{7}});
    chart.tells("received pose x qos 2");
    chart.gets(Pubrel{MsgId{7}});
    chart.sends(Pubcomp{MsgId{7}});
}

TEST_F(Receiving, AtQos2TellsTheMessageOnceThoughEveryDatagramComesTwice) {
    const auto message = publish_of(qos2, pose, MsgId{7}, "x");
    chart.gets(message);
    chart.sends(Pubrec{MsgId{7}});
    chart.tells("received pose x qos 2");
    chart.gets(message);  // duplicated on the way: without DUP
    chart.sends(Pubrec{MsgId{7}});
    chart.gets(again(message));  // PUBREC was lost
    chart.sends(Pubrec{MsgId{7}});
    for (int i = 0; i < 2; ++i) {  // PUBCOMP was lost
        chart.gets(Pubrel{MsgId{7}});
        chart.sends(Pubcomp{MsgId{7}});
    }
}

TEST_F(Receiving, AtQos2TakesAReleasedMsgIdForANewMessage) {
    for (const auto text : {"x", "y"}) {
        chart.gets(publish_of(qos2, pose, MsgId{7}, text));
        chart.sends(Pubrec{MsgId{7}});
        chart.tells(std::string("received pose ") + text + " qos 2");
        chart.gets(Pubrel{MsgId{7}});
        chart.sends(Pubcomp{MsgId{7}});
    }
}

TEST_F(Receiving, AtQos2IsOnceAcrossAReconnectInAKeptSession) {
    chart.gets(publish_of(qos2, pose, MsgId{7}, "x"));
    chart.sends(Pubrec{MsgId{7}});
    chart.tells("received pose x qos 2");
    chart.connect({.client_id = "c", .clean_session = false, .keep_alive = 0s});
    chart.gets(again(publish_of(qos2, pose, MsgId{7}, "x")));
    chart.sends(Pubrec{MsgId{7}});
    chart.gets(Pubrel{MsgId{7}});
    chart.sends(Pubcomp{MsgId{7}});
}

TEST_F(Receiving, ForgetsUnreleasedMsgIdsInACleanSession) {
    chart.gets(publish_of(qos2, pose, MsgId{7}, "x"));
    chart.sends(Pubrec{MsgId{7}});
    chart.tells("received pose x qos 2");
    chart.connect();
    chart.subscribe(topic_name("pose"), pose, qos2);
    chart.gets(publish_of(qos2, pose, MsgId{7}, "y"));
    chart.sends(Pubrec{MsgId{7}});
    chart.tells("received pose y qos 2");
}

TEST_F(Receiving, ForgetsTheOldestUnreleasedMsgIdWhenTheyAreTooMany) {  // P8
    for (std::uint16_t i = 0; i <= HostLimits::unreleased; ++i) {
        chart.gets(publish_of(qos2, pose, MsgId{i}, "x"));
        chart.sends(Pubrec{MsgId{i}});
        chart.tells("received pose x qos 2");
    }
    chart.gets(publish_of(qos2, pose, MsgId{1}, "x"));
    chart.sends(Pubrec{MsgId{1}});
    chart.gets(publish_of(qos2, pose, MsgId{0}, "x"));
    chart.sends(Pubrec{MsgId{0}});
    chart.tells("received pose x qos 2");
}

TEST_F(Receiving, OnAnUnknownTopicIdIsAnsweredByPuback2) {  // 6.10e
    for (const Qos qos : {qos0, qos1, qos2}) {
        chart.gets(publish_of(qos, TopicId{99}, MsgId{7}, "x"));
        chart.sends(Puback{TopicId{99}, MsgId{7}, invalid_topic_id});
    }
}

TEST_F(Receiving, OfAReservedTopicTypeIsACellsOrNothing) {  // cell_test.cpp
    chart.gets(Publish{false, qos1, false, TopicIdType::reserved, pose, MsgId{7}, {}});
    EXPECT_EQ(chart.client().dropped(), 1u);
}

TEST_F(Receiving, TellsRetain) {
    chart.gets(Publish{false, qos0, true, TopicIdType::normal, pose, no_msg_id, as_octets("x")});
    chart.tells("received pose x qos 0 retain");
}

TEST_F(Receiving, GoesOnWhileAnOwnPublishIsOutstanding) {
    chart.publish(topic_name("pose"), "mine", qos2);
    chart.sends(publish_of(qos2, pose, MsgId{2}, "mine"));
    chart.gets(publish_of(qos2, pose, MsgId{2}, "theirs"));  // the same number, the other way
    chart.sends(Pubrec{MsgId{2}});
    chart.tells("received pose theirs qos 2");
    chart.gets(Pubrec{MsgId{2}});
    chart.sends(Pubrel{MsgId{2}});
    chart.gets(Pubrel{MsgId{2}});
    chart.sends(Pubcomp{MsgId{2}});
    chart.gets(Pubcomp{MsgId{2}});
    chart.tells("published 2");
}

TEST_F(Receiving, CountsWhatIsNoMessageOrNotForAClient) {
    const std::uint8_t malformed[] = {0x05, 0x0C, 0x00};
    chart.gets_octets(malformed);
    chart.gets(Connect{false, true, protocol_id, 0, "c"});
    chart.gets(subscribe_of("a", qos0, MsgId{1}));
    chart.gets(Advertise{1, 900});
    EXPECT_EQ(chart.client().dropped(), 4u);
}

}  // namespace
}  // namespace romano::client::receiving_test
