// What a frame on the bridge is, from its first octets.
#include "bench/ros/tap.h"

#include <gtest/gtest.h>

#include <vector>

namespace romano::bench::ros::tap_test {
namespace {

using Octets = std::vector<std::uint8_t>;

/// Ethernet and IPv4 with that many octets behind its header.
Octets ipv4(std::uint8_t protocol, std::vector<std::uint8_t> to, unsigned behind_header) {
    const unsigned total = 20 + behind_header;
    Octets frame(14 + total, 0);
    frame[12] = 0x08;
    frame[14] = 0x45;
    frame[16] = static_cast<std::uint8_t>(total >> 8U);
    frame[17] = static_cast<std::uint8_t>(total);
    frame[23] = protocol;
    std::copy(to.begin(), to.end(), frame.begin() + 30);
    return frame;
}

TEST(PacketIn, CountsUdpBehindItsHeader) {
    const auto packet = packet_in(4, ipv4(17, {10, 60, 0, 5}, 8 + 39));
    ASSERT_TRUE(packet);
    EXPECT_EQ(packet->from, 4);
    EXPECT_EQ(packet->to, 5);
    EXPECT_EQ(packet->octets, 67U);
    EXPECT_EQ(packet->kind, Packet::Kind::udp);
    EXPECT_EQ(packet->transport_octets, 39U);
}

TEST(PacketIn, CountsTcpWithItsHeader) {
    const auto packet = packet_in(4, ipv4(6, {10, 60, 0, 5}, 32 + 48));
    ASSERT_TRUE(packet);
    EXPECT_EQ(packet->kind, Packet::Kind::tcp);
    EXPECT_EQ(packet->transport_octets, 80U);
}

TEST(PacketIn, TakesAServiceAddressForItsBroker) {
    EXPECT_EQ(packet_in(4, ipv4(17, {10, 60, 0, 203}, 20))->to, 3);
}

TEST(PacketIn, TakesMulticastForAll) {
    EXPECT_EQ(packet_in(4, ipv4(17, {239, 255, 0, 1}, 20))->to, 0);
    EXPECT_EQ(packet_in(4, ipv4(17, {10, 60, 0, 255}, 20))->to, 0);
}

TEST(PacketIn, IsNothingWhenBroken) {
    Octets frame = ipv4(17, {10, 60, 0, 5}, 40);
    EXPECT_FALSE(packet_in(1, Octets(frame.begin(), frame.begin() + 30)));
    Octets short_header = frame;
    short_header[14] = 0x44;
    EXPECT_FALSE(packet_in(1, short_header));
    Octets ipv6 = frame;
    ipv6[12] = 0x86;
    ipv6[13] = 0xDD;
    EXPECT_FALSE(packet_in(1, ipv6));
    frame[16] = frame[17] = 0;  // a total length below its header's
    EXPECT_FALSE(packet_in(1, frame));
}

}  // namespace
}  // namespace romano::bench::ros::tap_test
