// MQTT-SN 1.2 section 5.2.1: the length, its two forms, and what is no message at all.

#include "romano/mqttsn/frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "romano/mqttsn/codec.h"

namespace romano::mqttsn::frame_test {
namespace {

using testing::ElementsAre;
using Octets = std::vector<std::uint8_t>;

Octets encoded(const Message& message) {
    Octets octets(encoded_size(message));
    EXPECT_EQ(encode(message, octets), octets.size());
    return octets;
}

Message publish_of(const Octets& data) {
    return Publish{false,      Qos::at_most_once, false, TopicIdType::normal,
                   TopicId{1}, MsgId{0},          data};
}

TEST(Frame, NothingIsNoMessage) {
    EXPECT_EQ(decode(Bytes{}).error(), Malformed::empty);
}

TEST(Frame, LengthOfTheShortFormCountsItself) {
    const Octets pingresp{0x02, 0x17};
    const auto frame = decode_frame(pingresp);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->type, MsgType::pingresp);
    EXPECT_TRUE(frame->body.empty());
}

TEST(Frame, LongFormIsLegalForASmallMessageToo) {
    const Octets searchgw{0x01, 0x00, 0x05, 0x01, 0x07};
    const auto frame = decode_frame(searchgw);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->type, MsgType::searchgw);
    EXPECT_THAT(frame->body, ElementsAre(0x07));
}

TEST(Frame, LengthOtherThanTheDatagramsIsDropped) {
    for (const Octets& wrong :
         {Octets{0x00}, Octets{0x00, 0x17}, Octets{0x02}, Octets{0x03, 0x17},
          Octets{0x02, 0x17, 0x00}, Octets{0x01}, Octets{0x01, 0x00}, Octets{0x01, 0x00, 0x03},
          Octets{0x01, 0x00, 0x05, 0x17}, Octets{0x01, 0x00, 0x00, 0x17},
          Octets{0x01, 0x00, 0x04, 0x17, 0}}) {
        const auto message = decode(wrong);
        ASSERT_FALSE(message) << testing::PrintToString(wrong);
        EXPECT_EQ(message.error(), Malformed::length) << testing::PrintToString(wrong);
    }
}

TEST(Frame, ShortFormIsSentUpTo255OctetsAndTheLongFormFrom256) {
    const Octets of_255 = encoded(publish_of(Octets(248)));
    EXPECT_EQ(of_255.size(), 255u);
    EXPECT_EQ(of_255[0], 0xFF);
    const Octets longer = encoded(publish_of(Octets(249)));
    EXPECT_EQ(longer.size(), 258u);
    EXPECT_THAT(Octets(longer.begin(), longer.begin() + 4), ElementsAre(0x01, 0x01, 0x02, 0x0C));
}

TEST(Frame, PahosUncounted255OctetMessageIsTakenAtDatagramSize) {
    Octets octets(257);
    octets[0] = 0x01;
    octets[2] = 0xFF;
    octets[3] = 0x0C;
    const auto message = decode(octets);
    ASSERT_TRUE(message);
    EXPECT_EQ(std::get<Publish>(*message).data.size(), 248u);

    octets.push_back(0);
    EXPECT_EQ(decode(octets).error(), Malformed::length);
    octets.resize(257);
    octets[2] = 0xFE;
    EXPECT_EQ(decode(octets).error(), Malformed::length);
}

TEST(Frame, PahosUncounted256OctetMessageIsTakenAtDatagramSize) {
    Octets octets(258);
    octets[0] = 0x01;
    octets[1] = 0x01;
    octets[3] = 0x0C;
    const auto message = decode(octets);
    ASSERT_TRUE(message);
    EXPECT_EQ(std::get<Publish>(*message).data.size(), 249u);

    octets[2] = 0x01;
    EXPECT_EQ(decode(octets).error(), Malformed::length);
}

TEST(Frame, ReservedTypesAreDropped) {
    for (unsigned type = 0; type <= 0xFF; ++type) {
        const Octets octets{0x02, static_cast<std::uint8_t>(type)};
        const bool reserved = type == 0x03 || type == 0x11 || type == 0x19 ||
                              (type >= 0x1E && type <= 0xFD) || type == 0xFF;
        const auto message = decode(octets);
        EXPECT_EQ(reserved, !message && message.error() == Malformed::reserved_type) << type;
        EXPECT_EQ(reserved, name_of(static_cast<MsgType>(type)) == "RESERVED") << type;
    }
}

TEST(Frame, WhatDoesNotFitIsNotWritten) {
    const Message message = publish_of(Octets(10));
    Octets room(encoded_size(message) - 1, 0xAA);
    EXPECT_EQ(encode(message, room), 0u);
    EXPECT_THAT(room, testing::Each(0xAA));
}

TEST(Frame, LargestMessageHas65535Octets) {
    Octets room(70'000);
    EXPECT_EQ(encode(publish_of(Octets(65'526)), room), 65'535u);
    EXPECT_EQ(encode(publish_of(Octets(65'527)), room), 0u);
    const Octets octets = encoded(publish_of(Octets(65'526)));
    ASSERT_TRUE(decode(octets));
}

}  // namespace
}  // namespace romano::mqttsn::frame_test
