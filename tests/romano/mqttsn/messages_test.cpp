// MQTT-SN 1.2 section 5.4, message by message: the octets by hand, field by field.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string_view>
#include <vector>

#include "romano/mqttsn/codec.h"

namespace romano::mqttsn::messages_test {
namespace {

using testing::ElementsAre;
using Octets = std::vector<std::uint8_t>;

/// The message in `octets`; encoding it gives them again.
template <typename M>
class Wire {
public:
    explicit Wire(Octets octets) : octets_(std::move(octets)), decoded_(decode(octets_)) {
        EXPECT_TRUE(decoded_) << testing::PrintToString(octets_);
        if (!decoded_) return;
        EXPECT_TRUE(std::holds_alternative<M>(*decoded_));
        EXPECT_EQ(type_of(*decoded_), M::type);
        Octets again(octets_.size());
        EXPECT_EQ(encoded_size(*decoded_), octets_.size());
        EXPECT_EQ(encode(*decoded_, again), octets_.size());
        EXPECT_EQ(again, octets_);
    }
    const M* operator->() const { return &std::get<M>(*decoded_); }

private:
    Octets octets_;
    Decoded<Message> decoded_;
};

/// As Wire, but of octets that are not what encode() writes for the message.
template <typename M>
class Tolerated {
public:
    explicit Tolerated(Octets octets) : octets_(std::move(octets)), decoded_(decode(octets_)) {
        EXPECT_TRUE(decoded_) << testing::PrintToString(octets_);
    }
    const M* operator->() const { return &std::get<M>(*decoded_); }

private:
    Octets octets_;
    Decoded<Message> decoded_;
};

void expect_dropped(const Octets& octets, Malformed reason) {
    const auto decoded = decode(octets);
    ASSERT_FALSE(decoded) << testing::PrintToString(octets);
    EXPECT_EQ(decoded.error(), reason) << testing::PrintToString(octets);
}

TEST(Advertise, HoldsGatewayIdAndDuration) {  // 5.4.1
    const Wire<Advertise> m({0x05, 0x00, 0x07, 0x03, 0x84});
    EXPECT_EQ(m->gateway_id, 7);
    EXPECT_EQ(m->duration_s, 900);
}

TEST(Searchgw, HoldsRadius) {  // 5.4.2
    const Wire<Searchgw> m({0x03, 0x01, 0x02});
    EXPECT_EQ(m->radius, 2);
}

TEST(Gwinfo, OfAGatewayHasNoAddress) {  // 5.4.3
    const Wire<Gwinfo> m({0x03, 0x02, 0x07});
    EXPECT_EQ(m->gateway_id, 7);
    EXPECT_TRUE(m->gateway_address.empty());
}

TEST(Gwinfo, OfAClientHasTheGatewaysAddress) {
    const Wire<Gwinfo> m({0x07, 0x02, 0x07, 0x7F, 0x00, 0x00, 0x01});
    EXPECT_THAT(m->gateway_address, ElementsAre(0x7F, 0x00, 0x00, 0x01));
}

TEST(Connect, HoldsFlagsProtocolIdDurationAndClientId) {  // 5.4.4
    const Wire<Connect> m({0x08, 0x04, 0x0C, 0x01, 0x00, 0x3C, 'c', '1'});
    EXPECT_TRUE(m->will);
    EXPECT_TRUE(m->clean_session);
    EXPECT_EQ(m->protocol_id, 1);
    EXPECT_EQ(m->duration_s, 60);
    EXPECT_EQ(m->client_id, "c1");
    const Wire<Connect> plain({0x07, 0x04, 0x00, 0x01, 0x00, 0x00, 'c'});
    EXPECT_FALSE(plain->will);
    EXPECT_FALSE(plain->clean_session);
}

TEST(Connect, MayHaveAnEmptyClientIdOrALongOne) {  // G20: the broker decides
    const Wire<Connect> empty({0x06, 0x04, 0x04, 0x01, 0x00, 0x0A});
    EXPECT_EQ(empty->client_id, "");
    Octets octets{0x2E, 0x04, 0x04, 0x01, 0x00, 0x0A};
    octets.resize(46, 'x');
    EXPECT_EQ(Wire<Connect>(octets)->client_id.size(), 40u);
}

TEST(Connect, KeepsAWrongProtocolIdForTheRefusal) {  // 6.2c
    const Wire<Connect> m({0x07, 0x04, 0x04, 0x02, 0x00, 0x0A, 'c'});
    EXPECT_EQ(m->protocol_id, 2);
}

TEST(Connack, HoldsReturnCode) {  // 5.4.5
    const Wire<Connack> m({0x03, 0x05, 0x03});
    EXPECT_EQ(m->return_code, ReturnCode::not_supported);
}

TEST(ReturnCode, ReservedValuesAreReceivedAsRejections) {  // 5.3.10
    const Wire<Connack> m({0x03, 0x05, 0x7F});
    EXPECT_NE(m->return_code, ReturnCode::accepted);
}

TEST(Willtopicreq, HasNoFields) {
    const Wire<Willtopicreq> m({0x02, 0x06});
}  // 5.4.6

TEST(Willtopic, HoldsQosRetainAndTopic) {  // 5.4.7
    const Wire<Willtopic> m({0x05, 0x07, 0x30, 'w', 't'});
    EXPECT_EQ(m->qos, Qos::at_least_once);
    EXPECT_TRUE(m->retain);
    EXPECT_EQ(m->topic, "wt");
}

TEST(Willtopic, HasTwoEmptyForms) {  // 5.4.7, 6.3a
    const Wire<Willtopic> without_flags({0x02, 0x07});
    EXPECT_EQ(without_flags->topic, "");
    const Tolerated<Willtopic> with_flags({0x03, 0x07, 0x30});
    EXPECT_EQ(with_flags->topic, "");
}

TEST(Willmsgreq, HasNoFields) {
    const Wire<Willmsgreq> m({0x02, 0x08});
}  // 5.4.8

TEST(Willmsg, HoldsTheMessageWhichMayBeEmpty) {  // 5.4.9
    const Wire<Willmsg> m({0x04, 0x09, 0xFF, 0x00});
    EXPECT_THAT(m->message, ElementsAre(0xFF, 0x00));
    const Wire<Willmsg> empty({0x02, 0x09});
    EXPECT_TRUE(empty->message.empty());
}

TEST(Register, HoldsTopicIdMsgIdAndName) {  // 5.4.10
    const Wire<Register> m({0x0A, 0x0A, 0x12, 0x34, 0xAB, 0xCD, 'p', 'o', 's', 'e'});
    EXPECT_EQ(m->topic_id, TopicId{0x1234});
    EXPECT_EQ(m->msg_id, MsgId{0xABCD});
    EXPECT_EQ(m->topic_name, "pose");
}

TEST(Register, KeepsAnEmptyNameForTheRefusal) {  // 6.5b
    const Wire<Register> m({0x06, 0x0A, 0x00, 0x00, 0x00, 0x01});
    EXPECT_EQ(m->topic_name, "");
}

TEST(Regack, HoldsTopicIdMsgIdAndReturnCode) {  // 5.4.11
    const Wire<Regack> m({0x07, 0x0B, 0x00, 0x05, 0x00, 0x09, 0x01});
    EXPECT_EQ(m->topic_id, TopicId{5});
    EXPECT_EQ(m->msg_id, MsgId{9});
    EXPECT_EQ(m->return_code, ReturnCode::congestion);
}

TEST(Publish, HoldsFlagsTopicMsgIdAndData) {  // 5.4.12
    const Wire<Publish> m({0x09, 0x0C, 0xD0, 0x00, 0x05, 0x00, 0x09, 'h', 'i'});
    EXPECT_TRUE(m->dup);
    EXPECT_EQ(m->qos, Qos::exactly_once);
    EXPECT_TRUE(m->retain);
    EXPECT_EQ(m->topic_type, TopicIdType::normal);
    EXPECT_EQ(m->topic, TopicId{5});
    EXPECT_EQ(m->msg_id, MsgId{9});
    EXPECT_EQ(as_text(m->data), "hi");
}

TEST(Publish, MayHaveNoData) {
    const Wire<Publish> m({0x07, 0x0C, 0x00, 0x00, 0x05, 0x00, 0x00});
    EXPECT_TRUE(m->data.empty());
}

TEST(Publish, HoldsAShortNameFirstCharacterFirst) {  // 6.7
    const Wire<Publish> m({0x07, 0x0C, 0x02, 'a', 'b', 0x00, 0x00});
    EXPECT_EQ(m->topic_type, TopicIdType::short_name);
    EXPECT_EQ(m->topic, TopicId{0x6162});
}

TEST(Publish, AtQosMinusOneIsFlagBits11) {  // 5.3.4, 6.8
    const Wire<Publish> m({0x07, 0x0C, 0x61, 0x00, 0x05, 0x00, 0x00});
    EXPECT_EQ(m->qos, Qos::without_connection);
    EXPECT_EQ(m->topic_type, TopicIdType::predefined);
}

TEST(Publish, AtQosMinusOneWithANameInItsDataDecodes) {  // G19: the broker looks into it
    const Wire<Publish> m({0x0A, 0x0C, 0x60, 0x00, 0x02, 0x00, 0x00, 'a', 'b', 'x'});
    EXPECT_EQ(m->qos, Qos::without_connection);
    EXPECT_EQ(m->topic_type, TopicIdType::normal);
}

TEST(Publish, KeepsReservedTopicsForTheRefusal) {  // 5.3.4, 5.3.11
    const Wire<Publish> type({0x07, 0x0C, 0x03, 0x00, 0x05, 0x00, 0x00});
    EXPECT_EQ(type->topic_type, TopicIdType::reserved);
    const Wire<Publish> id({0x07, 0x0C, 0x00, 0xFF, 0xFF, 0x00, 0x00});
    EXPECT_EQ(id->topic, reserved_topic_id);
}

TEST(Puback, HoldsTopicIdMsgIdAndReturnCode) {  // 5.4.13
    const Wire<Puback> m({0x07, 0x0D, 0x00, 0x05, 0x00, 0x09, 0x02});
    EXPECT_EQ(m->topic_id, TopicId{5});
    EXPECT_EQ(m->msg_id, MsgId{9});
    EXPECT_EQ(m->return_code, ReturnCode::invalid_topic_id);
}

TEST(Pubcomp, IsType0E) {  // 5.4.14; not the order of MQTT
    const Wire<Pubcomp> m({0x04, 0x0E, 0x01, 0x02});
    EXPECT_EQ(m->msg_id, MsgId{0x0102});
}

TEST(Pubrec, IsType0F) {
    const Wire<Pubrec> m({0x04, 0x0F, 0x01, 0x02});
    EXPECT_EQ(m->msg_id, MsgId{0x0102});
}

TEST(Pubrel, IsType10) {
    const Wire<Pubrel> m({0x04, 0x10, 0x01, 0x02});
    EXPECT_EQ(m->msg_id, MsgId{0x0102});
}

TEST(Subscribe, HoldsAName) {  // 5.4.15
    const Wire<Subscribe> m({0x08, 0x12, 0xA0, 0x00, 0x09, 'a', '/', '#'});
    EXPECT_TRUE(m->dup);
    EXPECT_EQ(m->qos, Qos::at_least_once);
    EXPECT_EQ(m->msg_id, MsgId{9});
    EXPECT_EQ(m->topic.type, TopicIdType::normal);
    EXPECT_EQ(m->topic.name, "a/#");
}

TEST(Subscribe, HoldsAPredefinedId) {
    const Wire<Subscribe> m({0x07, 0x12, 0x41, 0x00, 0x09, 0x00, 0x05});
    EXPECT_EQ(m->qos, Qos::exactly_once);
    EXPECT_EQ(m->topic.type, TopicIdType::predefined);
    EXPECT_EQ(m->topic.id, TopicId{5});
    expect_dropped({0x06, 0x12, 0x41, 0x00, 0x09, 0x05}, Malformed::size);
    expect_dropped({0x08, 0x12, 0x41, 0x00, 0x09, 0x00, 0x05, 0x00}, Malformed::size);
}

TEST(Subscribe, HoldsAShortNameOfOneOrTwoOctets) {  // G18
    const Wire<Subscribe> two({0x07, 0x12, 0x02, 0x00, 0x09, 'a', 'b'});
    EXPECT_EQ(two->topic.type, TopicIdType::short_name);
    EXPECT_EQ(two->topic.name, "ab");
    const Wire<Subscribe> one({0x06, 0x12, 0x02, 0x00, 0x09, '#'});
    EXPECT_EQ(one->topic.name, "#");
    expect_dropped({0x08, 0x12, 0x02, 0x00, 0x09, 'a', 'b', 'c'}, Malformed::size);
}

TEST(Subscribe, HoldsSomeTopic) {
    for (std::uint8_t type = 0; type < 4; ++type) {
        expect_dropped({0x05, 0x12, type, 0x00, 0x09}, Malformed::size);
    }
}

TEST(Subscribe, KeepsReservedValuesForTheRefusal) {  // 6.9e
    const Wire<Subscribe> m({0x09, 0x12, 0x63, 0x00, 0x09, 'a', 'b', 'c', 'd'});
    EXPECT_EQ(m->qos, Qos::without_connection);
    EXPECT_EQ(m->topic.type, TopicIdType::reserved);
}

TEST(Suback, HoldsGrantedQosTopicIdMsgIdAndReturnCode) {  // 5.4.16
    const Wire<Suback> m({0x08, 0x13, 0x40, 0x00, 0x05, 0x00, 0x09, 0x00});
    EXPECT_EQ(m->qos, Qos::exactly_once);
    EXPECT_EQ(m->topic_id, TopicId{5});
    EXPECT_EQ(m->msg_id, MsgId{9});
    EXPECT_EQ(m->return_code, ReturnCode::accepted);
}

TEST(Unsubscribe, NamesItsTopicAsSubscribeDoes) {  // 5.4.17
    const Wire<Unsubscribe> name({0x08, 0x14, 0x00, 0x00, 0x09, 'a', '/', '#'});
    EXPECT_EQ(name->msg_id, MsgId{9});
    EXPECT_EQ(name->topic.name, "a/#");
    const Wire<Unsubscribe> id({0x07, 0x14, 0x01, 0x00, 0x09, 0x00, 0x05});
    EXPECT_EQ(id->topic.id, TopicId{5});
    const Wire<Unsubscribe> brief({0x07, 0x14, 0x02, 0x00, 0x09, 'a', 'b'});
    EXPECT_EQ(brief->topic.name, "ab");
    expect_dropped({0x05, 0x14, 0x00, 0x00, 0x09}, Malformed::size);
    expect_dropped({0x08, 0x14, 0x01, 0x00, 0x09, 0x00, 0x05, 0x00}, Malformed::size);
}

TEST(Unsuback, HoldsMsgId) {  // 5.4.18
    const Wire<Unsuback> m({0x04, 0x15, 0x00, 0x09});
    EXPECT_EQ(m->msg_id, MsgId{9});
}

TEST(Pingreq, HoldsTheClientIdOfASleeperOnly) {  // 5.4.19
    const Wire<Pingreq> awake({0x02, 0x16});
    EXPECT_EQ(awake->client_id, "");
    const Wire<Pingreq> asleep({0x04, 0x16, 'c', '1'});
    EXPECT_EQ(asleep->client_id, "c1");
}

TEST(Pingresp, HasNoFields) {
    const Wire<Pingresp> m({0x02, 0x17});
}  // 5.4.20

TEST(Disconnect, HoldsADurationWhenItBeginsASleep) {  // 5.4.21
    const Wire<Disconnect> plain({0x02, 0x18});
    EXPECT_FALSE(plain->has_duration);
    const Wire<Disconnect> sleep({0x04, 0x18, 0x01, 0x2C});
    EXPECT_TRUE(sleep->has_duration);
    EXPECT_EQ(sleep->duration_s, 300);
    expect_dropped({0x03, 0x18, 0x01}, Malformed::size);
}

TEST(Willtopicupd, IsAsWilltopic) {  // 5.4.22
    const Wire<Willtopicupd> m({0x05, 0x1A, 0x50, 'w', 't'});
    EXPECT_EQ(m->qos, Qos::exactly_once);
    EXPECT_TRUE(m->retain);
    EXPECT_EQ(m->topic, "wt");
    const Wire<Willtopicupd> without_flags({0x02, 0x1A});
    EXPECT_EQ(without_flags->topic, "");
    const Tolerated<Willtopicupd> with_flags({0x03, 0x1A, 0x00});
    EXPECT_EQ(with_flags->topic, "");
}

TEST(Willtopicresp, HoldsReturnCode) {  // 5.4.24
    const Wire<Willtopicresp> m({0x03, 0x1B, 0x00});
    EXPECT_EQ(m->return_code, ReturnCode::accepted);
}

TEST(Willmsgupd, HoldsTheMessageWhichMayBeEmpty) {  // 5.4.23
    const Wire<Willmsgupd> m({0x04, 0x1C, 'b', 'y'});
    EXPECT_EQ(as_text(m->message), "by");
    const Wire<Willmsgupd> empty({0x02, 0x1C});
    EXPECT_TRUE(empty->message.empty());
}

TEST(Willmsgresp, HoldsReturnCode) {  // 5.4.25
    const Wire<Willmsgresp> m({0x03, 0x1D, 0x01});
    EXPECT_EQ(m->return_code, ReturnCode::congestion);
}

TEST(Encapsulated, LengthCountsTheForwardersHeaderOnly) {  // 5.5
    const Wire<Encapsulated> m({0x05, 0xFE, 0x01, 0xAA, 0xBB, 0x02, 0x16});
    EXPECT_EQ(m->radius, 1);
    EXPECT_THAT(m->wireless_node_id, ElementsAre(0xAA, 0xBB));
    EXPECT_THAT(m->message, ElementsAre(0x02, 0x16));
}

TEST(Encapsulated, UnusedCtrlBitsAreIgnored) {  // 5.5b
    const Tolerated<Encapsulated> m({0x04, 0xFE, 0xFD, 0xAA, 0x02, 0x16});
    EXPECT_EQ(m->radius, 1);
}

TEST(Encapsulated, NodeIdMayHave252Octets) {  // 5.5c
    Octets octets{0xFF, 0xFE, 0x00};
    octets.resize(255, 0xAA);
    octets.insert(octets.end(), {0x02, 0x16});
    EXPECT_EQ(Wire<Encapsulated>(octets)->wireless_node_id.size(), 252u);
    const Octets node_id(253);
    const Octets message{0x02, 0x16};
    Octets room(300);
    EXPECT_EQ(encode(Encapsulated{0, node_id, message}, room), 0u);
}

TEST(Encapsulated, WithoutNodeIdOrMessageIsDropped) {  // 5.5c
    expect_dropped({0x03, 0xFE, 0x00, 0x02, 0x16}, Malformed::size);
    expect_dropped({0x04, 0xFE, 0x00, 0xAA}, Malformed::size);
    expect_dropped({0x04, 0xFE, 0x00, 0xAA, 0x02}, Malformed::size);
    expect_dropped({0x09, 0xFE, 0x00, 0xAA, 0x02, 0x16}, Malformed::length);
    expect_dropped({0x00, 0xFE, 0x00, 0xAA, 0x02, 0x16}, Malformed::length);
}

TEST(Encapsulated, InsideAnotherIsDropped) {  // 5.5c
    expect_dropped({0x04, 0xFE, 0x00, 0xAA, 0x04, 0xFE, 0x00, 0xBB, 0x02, 0x16},
                   Malformed::reserved_value);
}

TEST(Encapsulated, NeverHasTheLongForm) {  // 5.5a
    expect_dropped({0x01, 0x00, 0x08, 0xFE, 0x00, 0xAA, 0x02, 0x16}, Malformed::length);
}

TEST(Flags, UnusedBitsAreIgnored) {  // 5.3.4
    const Tolerated<Connect> connect({0x07, 0x04, 0xF3, 0x01, 0x00, 0x00, 'c'});
    EXPECT_FALSE(connect->will);
    EXPECT_FALSE(connect->clean_session);
    const Tolerated<Willtopic> will({0x04, 0x07, 0x8F, 'w'});
    EXPECT_EQ(will->qos, Qos::at_most_once);
    EXPECT_FALSE(will->retain);
    const Tolerated<Publish> publish({0x07, 0x0C, 0x0C, 0x00, 0x05, 0x00, 0x00});
    EXPECT_EQ(publish->topic_type, TopicIdType::normal);
    const Tolerated<Subscribe> subscribe({0x06, 0x12, 0x1C, 0x00, 0x09, 'a'});
    EXPECT_EQ(subscribe->topic.type, TopicIdType::normal);
    const Tolerated<Suback> suback({0x08, 0x13, 0x9F, 0x00, 0x05, 0x00, 0x09, 0x00});
    EXPECT_EQ(suback->qos, Qos::at_most_once);
    const Tolerated<Unsubscribe> unsubscribe({0x06, 0x14, 0xFC, 0x00, 0x09, 'a'});
    EXPECT_EQ(unsubscribe->topic.type, TopicIdType::normal);
}

TEST(Flags, EveryOctetGoesBothWays) {
    for (unsigned octet = 0; octet <= 0xFF; ++octet) {
        const Flags flags = flags_from_wire(static_cast<std::uint8_t>(octet));
        EXPECT_EQ(to_wire(flags), octet);
    }
}

}  // namespace
}  // namespace romano::mqttsn::messages_test
