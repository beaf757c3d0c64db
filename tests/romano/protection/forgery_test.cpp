// An attacker without the key: what it changes, cuts off or makes up is not accepted, and changes
// nothing for those who have the key.

#include <gtest/gtest.h>

#include "romano/base/random.h"
#include "tests/romano/protection/cell.h"

namespace romano::protection {
namespace {

class Forgery : public testing::Test {
protected:
    void SetUp() override { ASSERT_TRUE(broker.takes(robot.seal())); }
    void TearDown() override {  // whatever was tried
        EXPECT_TRUE(broker.takes(robot.seal()));
        EXPECT_TRUE(robot.takes(broker.seal()));
    }

    Robot robot;
    Broker broker{1};
    const Octets message = octets("270c2000010007" + hex(counting(32)));
};

TEST_F(Forgery, EveryFlippedBitIsFound) {
    const Octets up = robot.seal(message);
    const Octets down = broker.seal(message);
    for (std::size_t bit = 0; bit < 8 * up.size(); ++bit) {
        const auto flipped = [&](Octets packet) {
            packet[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
            return packet;
        };
        EXPECT_FALSE(broker.takes(flipped(up))) << bit;
        EXPECT_FALSE(robot.takes(flipped(down))) << bit;
    }
    EXPECT_TRUE(broker.takes(up));
    EXPECT_TRUE(robot.takes(down));
}

TEST_F(Forgery, EveryTruncationIsFound) {
    const Octets up = robot.seal(message);
    const Octets down = broker.seal(message);
    for (std::size_t size = 0; size < up.size(); ++size) {
        for (const bool has_true_length : {false, true}) {
            const auto cut = [&](Octets packet) {
                packet.resize(size);
                if (has_true_length && size != 0) packet[0] = static_cast<std::uint8_t>(size);
                return packet;
            };
            EXPECT_FALSE(broker.takes(cut(up))) << size;
            EXPECT_FALSE(robot.takes(cut(down))) << size;
        }
    }
}

TEST_F(Forgery, TheMessageOfOnePacketFitsNoOther) {
    const Octets one = robot.seal(message);
    const Octets two = robot.seal(message);
    for (std::size_t cut = 1; cut < one.size(); ++cut) {
        if (std::equal(one.begin(), one.begin() + static_cast<std::ptrdiff_t>(cut), two.begin())) {
            continue;  // still the second packet itself
        }
        Octets mixed = one;
        std::copy(two.begin() + static_cast<std::ptrdiff_t>(cut), two.end(),
                  mixed.begin() + static_cast<std::ptrdiff_t>(cut));
        EXPECT_FALSE(broker.takes(mixed)) << cut;
    }
}

TEST_F(Forgery, AnUnprotectedMessageIsNoPacket) {
    EXPECT_FALSE(broker.takes(pingreq));
    EXPECT_FALSE(robot.takes(pingresp));
    EXPECT_EQ(broker.refused(Refusal::unprotected), 1u);
    EXPECT_EQ(robot.refused(Refusal::unprotected), 1u);
}

TEST_F(Forgery, NoneOfTwoHundredThousandMadeUpPacketsIsTaken) {
    Random random{7};
    const Octets up = robot.seal();
    const Octets down = broker.seal();
    constexpr std::uint32_t packets = 100'000;
    for (std::uint32_t i = 0; i < packets; ++i) {
        // The header's fields are an attacker's best, number and all behind it are made up.
        const auto made_up = [&](Octets packet) {
            packet.resize(30 + random.below(20));
            packet[0] = static_cast<std::uint8_t>(packet.size());
            for (std::size_t at = 17; at < packet.size(); ++at) {
                packet[at] = static_cast<std::uint8_t>(random.next() >> 24U);
            }
            return packet;
        };
        ASSERT_FALSE(broker.takes(made_up(up))) << i;
        ASSERT_FALSE(robot.takes(made_up(down))) << i;
    }
    EXPECT_GT(broker.refused(Refusal::bad_tag), packets / 10 * 9);
    EXPECT_GT(robot.refused(Refusal::bad_tag), packets / 10 * 9);
}

TEST_F(Forgery, AnyOctetsAreNoPacket) {
    Random random{8};
    for (int i = 0; i < 100'000; ++i) {
        Octets packet(random.below(60));
        for (std::uint8_t& octet : packet) octet = static_cast<std::uint8_t>(random.next() >> 24U);
        ASSERT_FALSE(broker.takes(packet));
        ASSERT_FALSE(robot.takes(packet));
    }
}

}  // namespace
}  // namespace romano::protection
