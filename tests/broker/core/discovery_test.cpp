// Discovery, strangers, forwarders: MQTT-SN 1.2 sections 6.1, 5.5, 6.12 and the choices G4, G8.

#include <gtest/gtest.h>

#include <string>

#include "tests/broker/core/scripted_client.h"

namespace romano::broker::discovery_test {
namespace {

class Meeting : public ::testing::Test {
protected:
    ScriptedBroker broker;
    ScriptedClient stranger{broker, "stranger"};
};

TEST_F(Meeting, SearchgwIsAnsweredToAllAndToTheAsker) {  // 6.1b, G4
    stranger.says(Searchgw{1});
    EXPECT_EQ(stranger.hears<Gwinfo>().gateway_id, 1);
    ASSERT_EQ(broker.multicasts.size(), 1u);
    EXPECT_EQ(broker.multicasts[0], (Octets{3, 0x02, 1}));
}

TEST_F(Meeting, AdvertiseComesEveryTadv) {  // 6.1a
    BrokerOptions options = plain_options();
    options.advertise_every = 900s;
    ScriptedBroker advertising{options};
    advertising.waits(901s);
    ASSERT_EQ(advertising.multicasts.size(), 2u);
    EXPECT_EQ(advertising.multicasts[0], (Octets{5, 0x00, 1, 0x03, 0x84}));
}

TEST_F(Meeting, OtherGatewaysAndClientsThatTellOfThemAreHeardQuietly) {
    stranger.says(Advertise{2, 900});
    stranger.says(Gwinfo{2, {}});
    stranger.hears_nothing();
    EXPECT_EQ(broker.dropped(Drop::unknown_sender), 0u);
}

TEST_F(Meeting, RequestsOfAStrangerGetDisconnectAndAnswersNothing) {  // G8
    stranger.says(Publish{false, Qos::at_most_once, false, {}, TopicId{1}, no_msg_id, {}});
    stranger.hears<Disconnect>();
    stranger.says(Pubrel{MsgId{1}});
    stranger.hears<Disconnect>();
    stranger.says(Subscribe{false, Qos::at_most_once, MsgId{1}, {TopicIdType::normal, "a", {}}});
    stranger.hears<Disconnect>();
    stranger.says(Unsubscribe{MsgId{1}, {TopicIdType::normal, "a", {}}});
    stranger.hears<Disconnect>();
    stranger.says(Register{no_topic_id, MsgId{1}, "a"});
    stranger.hears<Disconnect>();
    stranger.says(Pingreq{});
    stranger.hears<Disconnect>();
    stranger.says(Willtopicupd{});
    stranger.hears<Disconnect>();
    stranger.says(Willmsgupd{});
    stranger.hears<Disconnect>();
    stranger.says(Disconnect{});
    stranger.hears<Disconnect>();

    stranger.says(Puback{TopicId{1}, MsgId{1}, ReturnCode::accepted});
    stranger.says(Pubrec{MsgId{1}});
    stranger.says(Pubcomp{MsgId{1}});
    stranger.says(Pingresp{});
    stranger.says(Regack{TopicId{1}, MsgId{1}, ReturnCode::accepted});
    stranger.hears_nothing();
    EXPECT_EQ(broker.dropped(Drop::unknown_sender), 14u);
}

TEST_F(Meeting, MessagesThatOnlyBrokersSendAreDropped) {
    stranger.connects();
    stranger.says(Connack{ReturnCode::accepted});
    stranger.says(Suback{});
    stranger.says(Willtopicreq{});
    stranger.hears_nothing();
    EXPECT_EQ(broker.dropped(Drop::wrong_direction), 3u);
}

TEST_F(Meeting, AnswersToOneStrangerAreLimitedInRate) {  // G8
    for (int i = 0; i < 1000; ++i) stranger.says(Pingreq{});
    EXPECT_EQ(stranger.unheard(), 200u);
    EXPECT_EQ(broker.dropped(Drop::stranger_rate), 800u);
    broker.waits(1s);
    stranger.ignores_what_came();
    stranger.says(Pingreq{});
    stranger.hears<Disconnect>();
}

TEST_F(Meeting, EveryMalformedDatagramIsCountedByItsReason) {
    stranger.says_octets({});
    stranger.says_octets({5, 0x0C, 0});
    stranger.says_octets({2, 0x03});
    stranger.says_octets({3, 0x0F, 1});
    const auto& malformed = broker.core.counters().malformed;
    EXPECT_EQ(malformed[static_cast<std::size_t>(Malformed::empty)], 1u);
    EXPECT_EQ(malformed[static_cast<std::size_t>(Malformed::length)], 1u);
    EXPECT_EQ(malformed[static_cast<std::size_t>(Malformed::reserved_type)], 1u);
    EXPECT_EQ(malformed[static_cast<std::size_t>(Malformed::size)], 1u);
    stranger.hears_nothing();
}

TEST_F(Meeting, NodesBehindOneForwarderAreClientsOfTheirOwn) {  // 5.5c
    ScriptedClient left{broker, "left", 40'000};
    ScriptedClient right{broker, "right", 40'000};
    left.address.wireless_node_id = "\x01";
    right.address.wireless_node_id = "\x02\x03\x04\x05";
    left.connects();
    right.connects();
    right.subscribes("pose");
    left.publishes(left.registers("pose"), "x", Qos::exactly_once);
    right.hears_publish("x", Qos::exactly_once);
    left.hears_nothing();
    EXPECT_EQ(broker.core.session_count(), 2u);
}

TEST_F(Meeting, AnswerToAForwarderHasTheSameWrapping) {  // 5.5a
    stranger.address.wireless_node_id = "node";
    stranger.says(stranger.connect());
    ASSERT_EQ(stranger.unheard(), 1u);
    EXPECT_EQ((broker.inboxes[{broker.via, stranger.address}].front()),
              (Octets{7, 0xFE, 0, 'n', 'o', 'd', 'e', 3, 0x05, 0}));
}

TEST_F(Meeting, NodeIdMayChange) {  // 5.5c
    ScriptedClient node{broker, "node", 40'000};
    node.address.wireless_node_id = "old";
    node.connects(false);
    node.subscribes("cmd");
    ScriptedClient renamed{broker, "node", 40'000};
    renamed.address.wireless_node_id = "new";
    renamed.connects(false);
    EXPECT_EQ(broker.core.session_count(), 1u);
    EXPECT_EQ(broker.core.image("node")->subscriptions.size(), 1u);
}

TEST_F(Meeting, ForwardersFrameThatHoldsNoneOrANestedOneIsDropped) {  // 5.5c
    stranger.says_octets({3, 0xFE, 0, 2, 0x16});                      // no node id
    stranger.says_octets({4, 0xFE, 0, 'n'});                          // no message
    stranger.says_octets({4, 0xFE, 0, 'n', 4, 0xFE, 0, 'm', 2, 0x16});
    stranger.hears_nothing();
}

TEST_F(Meeting, ServesTellsWhetherADatagramBelongsHere) {
    stranger.connects();
    const auto ping = ScriptedClient::encoded(Pingreq{});
    const auto connect = ScriptedClient::encoded(stranger.connect());
    EXPECT_TRUE(broker.core.serves(broker.via, stranger.address.endpoint, ping));
    EXPECT_FALSE(broker.core.serves(broker.via, loopback(9, 9), ping));
    EXPECT_TRUE(broker.core.serves(broker.via, loopback(9, 9), connect));  // a known client id
    EXPECT_FALSE(broker.core.serves(broker.via, stranger.address.endpoint, {}));
}

}  // namespace
}  // namespace romano::broker::discovery_test
