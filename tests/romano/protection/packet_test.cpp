// The octets of the Protection Encapsulation. The packets here were made by another implementation
// (of SHA-256, HKDF and AES-CCM) from the table in the README.

#include "romano/protection/packet.h"

#include <gtest/gtest.h>

#include "romano/protection/ccm.h"
#include "romano/protection/packet_cipher.h"
#include "tests/romano/protection/hex.h"

namespace romano::protection {
namespace {

const DirectionKeys keys = direction_keys({counting_array<16>()});

TEST(Packet, OfARobotsPingreqIsOctetForOctetAsTheTableSays) {
    Octets room(100);
    room.resize(write({sender_id("abcd1234"), RunId{0x1000}, 0x1002}, octets("0216"),
                      keys.to_broker, room));
    EXPECT_EQ(hex(room),
              "1e"                // length
              "ff"                // PROTECTION
              "12"                // tag of the scheme's size, no key material, counter of 32 bits
              "40"                // AES-CCM-64-128
              "e9cee71ab932fde8"  // sender: SHA-256 of "abcd1234"
              "00001000"          // run
              "00001002"          // counter
              "ad98"              // PINGREQ
              "4b6610480ff4aec8"  // tag
    );
}

TEST(Packet, OfABrokersPublishIsOctetForOctetAsTheTableSays) {
    const Octets message = octets("270c2000010007" + hex(counting(32)));
    Octets room(100);
    room.resize(
        write({counting_array<8>(1), RunId{0x1000}, 0xFFFE0001}, message, keys.to_robot, room));
    EXPECT_EQ(hex(room),
              "43ff1240010203040506070800001000fffe0001"
              "3ca1709d103f7a221c3670a78914d6199aaa325700498243f4694b558f126da6253c72938921ee"
              "28f47fce88df37e2");
}

TEST(Packet, TakesTheLongFormOfTheLengthFrom256OctetsOn) {
    Octets message(260);
    message[0] = message[1] = 1;
    message[2] = 4;
    message[3] = 0x0C;
    Octets room(300);
    room.resize(write({sender_id("abcd1234"), RunId{0}, 0}, message, keys.to_broker, room));
    ASSERT_EQ(room.size(), 290u);
    EXPECT_EQ(hex(Bytes{room}.first(24)), "010122ff1240e9cee71ab932fde80000000000000000c8db");
    EXPECT_EQ(hex(Bytes{room}.last(8)), "1261808dabe920fa");
    EXPECT_EQ(write({}, Octets(255 - 28), keys.to_broker, room), 255u);
    EXPECT_EQ(write({}, Octets(256 - 28), keys.to_broker, room), 258u);
}

TEST(Packet, SaysAgainWhatWasWritten) {
    for (std::size_t size = 2; size < 600; ++size) {
        const Octets message = counting(size, static_cast<std::uint8_t>(size));
        const Fields fields{counting_array<8>(9), RunId{0xA1B2C3D4}, 0x01020304};
        Octets room(700);
        room.resize(write(fields, message, keys.to_robot, room));
        ASSERT_LE(room.size(), size + most_overhead);
        const auto packet = parse(room);
        ASSERT_TRUE(packet) << size;
        EXPECT_EQ(packet->fields().sender, fields.sender);
        EXPECT_EQ(packet->fields().run, fields.run);
        EXPECT_EQ(packet->fields().number, fields.number);
        ASSERT_TRUE(open(*packet, keys.to_robot)) << size;
        EXPECT_EQ(hex(packet->message()), hex(message));
    }
}

TEST(Packet, IsSealedByTheCcmThatTheVectorsAreOf) {
    for (std::size_t size = 1; size < 600; ++size) {
        Octets message = counting(size, static_cast<std::uint8_t>(size));
        Octets expected = message;
        const Octets header = counting(20 + size % 2 * 2, static_cast<std::uint8_t>(3 * size));
        Octets tag(tag_size);
        Octets expected_tag(tag_size);
        protection::seal(keys.to_robot, header, message, tag);
        Ccm{keys.to_robot, nonce_of(header)}.seal(header, expected, expected_tag);
        ASSERT_EQ(hex(message), hex(expected)) << size;
        ASSERT_EQ(hex(tag), hex(expected_tag)) << size;
    }
}

TEST(Packet, LeavesNothingOfAMessageWhoseTagIsWrong) {
    Octets message = counting(40);
    EXPECT_FALSE(protection::open(keys.to_robot, counting(20), message, Octets(tag_size)));
    EXPECT_EQ(message, Octets(40));
}

TEST(Packet, MayBeWrittenOverItsMessage) {
    const Octets message = counting(40);
    Octets apart(100);
    apart.resize(write({}, message, keys.to_robot, apart));
    for (const std::size_t at : {0U, 1U, 10U, 20U, 28U, 60U}) {
        Octets room(100);
        std::copy(message.begin(), message.end(), room.begin() + static_cast<std::ptrdiff_t>(at));
        room.resize(write({}, Bytes{room}.subspan(at, message.size()), keys.to_robot, room));
        EXPECT_EQ(room, apart) << at;
    }
}

TEST(Packet, IsNotWrittenWhereItHasNoRoom) {
    const Octets message = counting(40);
    Octets room(67, 0xAA);
    EXPECT_EQ(write({}, message, keys.to_robot, room), 0u);
    EXPECT_EQ(room, Octets(67, 0xAA));
    Octets large(70'000);
    EXPECT_EQ(write({}, Octets(65'506), keys.to_robot, large), 0u);
    EXPECT_EQ(write({}, Octets(65'505), keys.to_robot, large), 65'535u);
}

TEST(Packet, OfAnotherKindIsRefusedUnread) {
    const Octets good = octets("1eff1240e9cee71ab932fde80000100000001002ad984b6610480ff4aec8");
    const auto parse_with = [&](std::size_t at, unsigned value) {
        Octets changed = good;
        changed[at] = static_cast<std::uint8_t>(value);
        return parse(changed);
    };
    ASSERT_TRUE(parse_with(0, 0x1E));
    EXPECT_EQ(parse_with(1, 0x16).error(), Refusal::unprotected);
    for (unsigned value = 0; value <= 0xFF; ++value) {
        if (value != 0x12) {
            EXPECT_EQ(parse_with(2, value).error(), Refusal::unknown_scheme);
        }
        if (value != 0x40) {
            EXPECT_EQ(parse_with(3, value).error(), Refusal::unknown_scheme);
        }
    }
    for (std::size_t size = 0; size < good.size(); ++size) {
        Octets cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
        EXPECT_EQ(parse(cut).error(), Refusal::malformed) << size;
        if (size < 2) continue;
        cut[0] = static_cast<std::uint8_t>(size);  // also with a length that is true
        EXPECT_EQ(parse(cut).error(), Refusal::malformed) << size;
    }
}

}  // namespace
}  // namespace romano::protection
