// Datagrams over the line between controller and radio.
#include "firmware/radio/line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <deque>
#include <numeric>
#include <vector>

#include "romano/base/random.h"

namespace romano::radio::line_test {
namespace {

using namespace std::chrono_literals;
using Octets = std::vector<std::uint8_t>;

Endpoint broker() {
    return {.address = {10, 0, 0, 7}, .port = 1883, .family = Endpoint::Family::ipv4};
}

Octets counting(std::size_t size) {
    Octets octets(size);
    std::iota(octets.begin(), octets.end(), std::uint8_t{0});
    return octets;
}

/// Both ends, and a line that may flip bits.
class Pair : public testing::Test {
protected:
    struct End {
        End(PacketType sends, Duration repeat_after)
            : line(sends, to_send, to_receive, repeat_after) {}
        std::array<std::uint8_t, 2048> to_send{};
        std::array<std::uint8_t, 1024> to_receive{};
        Line line;
        std::vector<std::pair<Endpoint, Octets>> received;
        std::vector<PacketType> packets;
    };

    void run_for(Duration time) {
        for (const Instant end = now + time; now < end; now += 1ms) {
            controller.line.on_tick(now);
            radio.line.on_tick(now);
            carry(controller, radio);
            carry(radio, controller);
        }
    }

    Instant now{};
    End controller{PacketType::send_udp, 50ms};
    End radio{PacketType::forward_udp, 100ms};
    Random random{1};
    std::uint32_t errors_per_million = 0;

private:
    void carry(End& from, End& to) {
        const Bytes out = from.line.line_out();
        const Octets octets{out.begin(), out.end()};
        from.line.clear_line_out();
        for (std::uint8_t octet : octets) {
            if (random.happens(errors_per_million)) octet ^= 0x10;
            const auto input = to.line.on_octet(now, octet);
            if (input.packet) to.packets.push_back(input.packet->type);
            if (input.datagram) {
                const Bytes data = input.datagram->octets;
                to.received.push_back({input.datagram->peer, {data.begin(), data.end()}});
            }
        }
    }
};

TEST_F(Pair, DatagramsOfEverySizeArriveInOrderWithTheirAddress) {
    std::vector<Octets> sent;
    for (const std::size_t size : {0U, 1U, 48U, 49U, 50U, 100U, 255U, 264U, 1000U}) {
        sent.push_back(counting(size));
        controller.line.send(now, {broker(), unknown_dbm, sent.back()});
        run_for(100ms);
    }
    ASSERT_EQ(radio.received.size(), sent.size());
    for (std::size_t i = 0; i < sent.size(); ++i) {
        EXPECT_EQ(radio.received[i].first, broker());
        EXPECT_EQ(radio.received[i].second, sent[i]) << i;
    }
}

TEST_F(Pair, SeveralAtOnceWaitInOrder) {
    for (std::uint8_t i = 0; i < 5; ++i) {
        const Octets octets(100, i);
        radio.line.send(now, {broker(), -60, octets});
    }
    run_for(200ms);
    ASSERT_EQ(controller.received.size(), 5U);
    for (std::uint8_t i = 0; i < 5; ++i) EXPECT_EQ(controller.received[i].second, Octets(100, i));
}

TEST_F(Pair, IPv6AndTheDiscoveryGroupHaveTheirAddresses) {
    Endpoint v6{.address = {0xFE, 0x80, 1}, .port = 1, .family = Endpoint::Family::ipv6};
    controller.line.send(now, {v6, unknown_dbm, counting(3)});
    controller.line.send(now, {Endpoint{}, unknown_dbm, counting(3)});
    run_for(100ms);
    ASSERT_EQ(radio.received.size(), 2U);
    EXPECT_EQ(radio.received[0].first, v6);
    EXPECT_EQ(radio.received[1].first, Endpoint{});
}

TEST_F(Pair, ABadLineLosesNothingAndDoublesNothing) {
    errors_per_million = 3000;
    for (std::uint8_t i = 0; i < 50; ++i) {
        const Octets octets(150, i);
        controller.line.send(now, {broker(), unknown_dbm, octets});
        run_for(1s);
    }
    ASSERT_EQ(radio.received.size(), 50U);
    for (std::uint8_t i = 0; i < 50; ++i) EXPECT_EQ(radio.received[i].second, Octets(150, i));
    EXPECT_GT(controller.line.link().repeats(), 0U);
}

TEST_F(Pair, WhatDoesNotFitIsLostAndCounted) {
    for (int i = 0; i < 20; ++i) {
        controller.line.send(now, {broker(), unknown_dbm, counting(200)});
    }
    EXPECT_GT(controller.line.lost(), 0U);
    run_for(2s);
    EXPECT_EQ(radio.received.size() + controller.line.lost(), 20U);
}

TEST_F(Pair, TheRadioTellsTheControllerItsId) {
    ASSERT_TRUE(radio.line.send_packet(now, PacketType::hwaddr_get, counting(8)));
    run_for(10ms);
    EXPECT_THAT(controller.packets, testing::ElementsAre(PacketType::hwaddr_get));
}

TEST(Assembler, APartOutOfTurnEndsTheDatagram) {
    std::array<std::uint8_t, 64> room{};
    Assembler assembler{room};
    const Octets first{0x80, 127, 0, 'a'};
    const Octets third{0x02, 'c'};
    EXPECT_FALSE(assembler.on_part(first));
    EXPECT_FALSE(assembler.on_part(third));
    EXPECT_EQ(assembler.dropped(), 1U);
    const Octets whole{0x00, 127, 0, 'x'};
    ASSERT_TRUE(assembler.on_part(whole));
}

TEST(Assembler, WhatIsNoPartOrTooMuchIsDropped) {
    std::array<std::uint8_t, 2> room{};
    Assembler assembler{room};
    for (const Octets& part : {Octets{}, Octets{0}, Octets{0, 127}, Octets{0, 127, 5, 1},
                               Octets{0, 127, 4, 1, 2, 3, 4, 5}, Octets{0, 127, 0, 1, 2, 3}}) {
        EXPECT_FALSE(assembler.on_part(part));
    }
    EXPECT_EQ(assembler.dropped(), 6U);
}

}  // namespace
}  // namespace romano::radio::line_test
