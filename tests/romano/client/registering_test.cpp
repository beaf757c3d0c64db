// MQTT-SN 1.2 section 6.5: topic ids for names.

#include <gtest/gtest.h>

#include <string>

#include "tests/romano/client/exchange.h"
#include "tests/romano/client/sequence_chart.h"

namespace romano::client::registering_test {
namespace {

using namespace mqttsn;
using enum ReturnCode;

class Registering : public testing::Test {
protected:
    void SetUp() override { chart.connect(); }
    void registers(std::string_view name) {
        chart.call([&](auto& client, auto now, auto& out) {
            ASSERT_TRUE(client.register_name(now, name, out));
        });
    }
    SequenceChart chart;
};

TEST_F(Registering, IsRegisterAndRegack) {
    registers("pose");
    chart.sends(register_of("pose", MsgId{1}));
    chart.gets(Regack{TopicId{5}, MsgId{1}, accepted});
    chart.tells("registered 1 id 5");
}

TEST_F(Registering, IsRepeatedWhenItOrRegackIsLost) {
    registers("pose");
    chart.sends(register_of("pose", MsgId{1}));
    chart.after(t_retry);
    chart.sends(register_of("pose", MsgId{1}));
    chart.gets(Regack{TopicId{5}, MsgId{1}, accepted});
    chart.tells("registered 1 id 5");
}

TEST_F(Registering, GivesUpTheBrokerAfterNretryRepetitions) {  // 6.13
    registers("pose");
    for (int sent = 0; sent < 1 + n_retry; ++sent) {
        chart.sends(register_of("pose", MsgId{1}));
        chart.after(t_retry);
    }
    chart.tells("lost");
}

TEST_F(Registering, ComesBeforeTheFirstPublishOnAName) {
    chart.publish(topic_name("pose"), "x", qos1);
    chart.sends(register_of("pose", MsgId{1}));
    chart.gets(Regack{TopicId{5}, MsgId{1}, accepted});
    chart.sends(publish_of(qos1, TopicId{5}, MsgId{2}, "x"));
    chart.gets(Puback{TopicId{5}, MsgId{2}, accepted});
    chart.tells("published 1");
    chart.publish(topic_name("pose"), "y", qos0);
    chart.sends(publish_of(qos0, TopicId{5}, no_msg_id, "y"));
    chart.tells("published 2");
}

TEST_F(Registering, HappensOnceForManyMessagesAtQos0InTheirOrder) {  // P5
    for (const auto text : {"1", "2", "3", "4", "5"}) {
        chart.publish(topic_name("pose"), text, qos0);
    }
    chart.sends(register_of("pose", MsgId{1}));
    chart.gets(Regack{TopicId{5}, MsgId{1}, accepted});
    chart.publish(topic_name("pose"), "6", qos0);
    chart.after(Duration::zero());
    int operation = 0;
    for (const auto text : {"1", "2", "3", "4", "5", "6"}) {
        chart.sends(publish_of(qos0, TopicId{5}, no_msg_id, text));
        chart.tells("published " + std::to_string(++operation));
    }
}

TEST_F(Registering, RefusedFailsThePublish) {  // 6.5b
    chart.publish(topic_name("a/+"), "x", qos1);
    chart.sends(register_of("a/+", MsgId{1}));
    chart.gets(Regack{no_topic_id, MsgId{1}, not_supported});
    chart.tells("failed 1 code 3");
}

TEST_F(Registering, UnderAReservedIdFails) {  // 5.3.11
    registers("pose");
    chart.sends(register_of("pose", MsgId{1}));
    chart.gets(Regack{reserved_topic_id, MsgId{1}, accepted});
    chart.tells("failed 1 code 2");
}

TEST_F(Registering, IsAskedAgainAfterTwaitWhenTheBrokerIsCongested) {
    registers("pose");
    chart.sends(register_of("pose", MsgId{1}));
    chart.gets(Regack{no_topic_id, MsgId{1}, congestion});
    chart.tells("congested");
    chart.after(t_wait - t_retry);
    chart.is_silent();
    chart.after(t_retry);
    chart.sends(register_of("pose", MsgId{2}));
    chart.gets(Regack{TopicId{5}, MsgId{2}, accepted});
    chart.tells("registered 1 id 5");
}

TEST_F(Registering, IgnoresARegackOfAnotherRequest) {
    registers("pose");
    chart.sends(register_of("pose", MsgId{1}));
    chart.gets(Regack{TopicId{5}, MsgId{2}, accepted});
    EXPECT_EQ(chart.client().dropped(), 1u);
}

TEST_F(Registering, ByTheBrokerIsAnsweredEachTime) {  // 6.10a
    for (int i = 0; i < 2; ++i) {
        chart.gets(Register{TopicId{9}, MsgId{77}, "a/b"});
        chart.sends(Regack{TopicId{9}, MsgId{77}, accepted});
    }
    chart.gets(publish_of(qos0, TopicId{9}, no_msg_id, "x"));
    chart.tells("received a/b x qos 0");
}

TEST_F(Registering, ByTheBrokerMayGiveAKnownIdANewName) {
    chart.gets(Register{TopicId{9}, MsgId{77}, "a/b"});
    chart.sends(Regack{TopicId{9}, MsgId{77}, accepted});
    chart.gets(Register{TopicId{9}, MsgId{78}, "c"});
    chart.sends(Regack{TopicId{9}, MsgId{78}, accepted});
    chart.gets(publish_of(qos0, TopicId{9}, no_msg_id, "x"));
    chart.tells("received c x qos 0");
}

TEST_F(Registering, ByTheBrokerOfNoTopicIsRefused) {
    chart.gets(Register{no_topic_id, MsgId{1}, "a"});
    chart.sends(Regack{no_topic_id, MsgId{1}, invalid_topic_id});
    chart.gets(Register{TopicId{9}, MsgId{2}, ""});
    chart.sends(Regack{TopicId{9}, MsgId{2}, not_supported});
}

// Each operator who asks a robot has an answer's topic of his own.
TEST_F(Registering, NeverEndsForWantOfRoomAndWhatIsReceivedStays) {
    chart.gets(Register{TopicId{9999}, MsgId{9999}, "commands"});
    chart.sends(Regack{TopicId{9999}, MsgId{9999}, accepted});
    for (std::uint16_t i = 1; i <= 3 * HostLimits::topics; ++i) {
        const std::string name = "answer-" + std::to_string(i);
        registers(name);
        chart.sends(register_of(name, MsgId{i}));
        chart.gets(Regack{TopicId{i}, MsgId{i}, accepted});
        chart.tells("registered " + std::to_string(i) + " id " + std::to_string(i));
    }
    chart.gets(publish_of(qos0, TopicId{9999}, no_msg_id, "x"));
    chart.tells("received commands x qos 0");
}

TEST_F(Registering, ByTheBrokerIsAnsweredByCongestionWhenTheTableIsFull) {
    for (std::uint16_t i = 1; i <= HostLimits::topics; ++i) {
        const std::string name = "t" + std::to_string(i);
        chart.gets(Register{TopicId{i}, MsgId{i}, name});
        chart.sends(Regack{TopicId{i}, MsgId{i}, accepted});
    }
    chart.gets(Register{TopicId{999}, MsgId{999}, "one more"});
    chart.sends(Regack{TopicId{999}, MsgId{999}, congestion});
    registers("mine");
    chart.tells("failed 1 code 1");
}

}  // namespace
}  // namespace romano::client::registering_test
