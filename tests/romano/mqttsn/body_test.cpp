// The bodies as data say what the messages' own decoders and encoders say.

#include "romano/mqttsn/body.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "romano/mqttsn/codec.h"

namespace romano::mqttsn::body_test {
namespace {

using Octets = std::vector<std::uint8_t>;

/// All that go between a client and its broker or to the discovery group, except SUBSCRIBE and
/// UNSUBSCRIBE, whose topic a broker looks at more closely.
constexpr MsgType types[] = {
    MsgType::advertise,   MsgType::searchgw,   MsgType::gwinfo,       MsgType::connect,
    MsgType::connack,     MsgType::willtopic,  MsgType::willtopicreq, MsgType::willmsgreq,
    MsgType::willmsg,     MsgType::register_,  MsgType::regack,       MsgType::publish,
    MsgType::puback,      MsgType::pubcomp,    MsgType::pubrec,       MsgType::pubrel,
    MsgType::suback,      MsgType::unsuback,   MsgType::pingreq,      MsgType::pingresp,
    MsgType::disconnect,  MsgType::willmsgupd, MsgType::willtopicupd, MsgType::willtopicresp,
    MsgType::willmsgresp,
};

/// 00 01 00 01..., which is also protocol id 1.
Octets body_of(std::size_t size) {
    Octets octets(size);
    for (std::size_t i = 1; i < size; i += 2) octets[i] = 1;
    return octets;
}

Octets message_of(MsgType type, const Octets& body) {
    Octets octets(2 + body.size());
    octets[0] = static_cast<std::uint8_t>(octets.size());
    octets[1] = static_cast<std::uint8_t>(type);
    std::ranges::copy(body, octets.begin() + 2);
    return octets;
}

TEST(BodyAsData, IsReadInExactlyTheSizesOfItsType) {  // section 5.4
    for (const MsgType type : types) {
        for (std::size_t size = 0; size < 12; ++size) {
            const Octets body = body_of(size);
            EXPECT_EQ(read_body(type, body).has_value(), decode(message_of(type, body)).has_value())
                << name_of(type) << " with " << size << " octets";
        }
    }
}

TEST(BodyAsData, IsWrittenAsItWasRead) {
    for (const MsgType type : types) {
        for (std::size_t size = 0; size < 12; ++size) {
            const Octets body = body_of(size);
            const auto read = read_body(type, body);
            const bool is_will_without_topic =
                size == 1 && (type == MsgType::willtopic || type == MsgType::willtopicupd);
            if (!read || is_will_without_topic) continue;
            Octets written(64);
            written.resize(write_message(type, *read, written));
            EXPECT_EQ(written, message_of(type, body)) << name_of(type);
        }
    }
}

TEST(BodyAsData, OfAWillWithoutTopicIsEmpty) {  // section 5.4.7, which deletes the will
    Octets written(64);
    written.resize(write_message(MsgType::willtopicupd, {.flags = 0x10}, written));
    EXPECT_EQ(written, (Octets{0x02, 0x1A}));
}

TEST(BodyAsData, AnswersItsRequestWithTheFieldsOfBoth) {
    const Octets body{0x20, 0x00, 0x05, 0x12, 0x34, 'x'};
    const auto publish = read_body(MsgType::publish, body);
    ASSERT_TRUE(publish);
    Octets written(64);
    written.resize(write_message(MsgType::puback, *publish, written));
    EXPECT_EQ(written, (Octets{0x07, 0x0D, 0x00, 0x05, 0x12, 0x34, 0x00}));
}

TEST(BodyAsData, OfAReservedTypeHasNoFields) {
    for (const unsigned type : {0x03U, 0x11U, 0x19U, 0x1EU, 0xFEU, 0xFFU}) {
        EXPECT_FALSE(read_body(MsgType(type), Octets{1}));
    }
}

TEST(BodyAsData, IsNotWrittenWhereItDoesNotFit) {
    Octets small(6);
    EXPECT_EQ(write_message(MsgType::puback, {}, small), 0U);
}

}  // namespace
}  // namespace romano::mqttsn::body_test
