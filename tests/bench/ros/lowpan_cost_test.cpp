// What frames and airtime are computed, against ns-3's 6LoWPAN, octet by octet.
#include "bench/ros/lowpan_cost.h"

#include <gtest/gtest.h>

#include "overlay/radio/channel.h"

namespace romano::bench::ros::lowpan_cost_test {
namespace {

constexpr double loud_dbm = -40;
constexpr double quiet_dbm = -93;

/// One datagram on an empty channel, between a router and its robot.
RadioCost by_ns3(std::size_t octets, bool to_everybody) {
    lowpan::Channel channel(
        {{lowpan::first_channel, 1}}, 0, quiet_dbm, 1,
        {[](lowpan::Device, lowpan::Device) { return loud_dbm; },
         [](lowpan::Device, lowpan::Device, const std::vector<std::uint8_t>&) {},
         [](lowpan::Device) {}});
    const std::vector<std::uint8_t> datagram(octets, 0x2A);
    if (to_everybody) {
        channel.broadcast(0, {0, 0}, datagram);
    } else {
        channel.send(0, {0, 0}, {0, 1}, datagram);
    }
    channel.run_until(1'000'000'000);
    const lowpan::Counters& all = channel.counters();
    const double acknowledgements = static_cast<double>(channel.sent_by({0, 1}).frames);
    return {.frames = static_cast<double>(all.frames) - acknowledgements,
            .air_ms = static_cast<double>(
                          lowpan::air_time_ns({.frames = all.frames, .octets = all.air_octets})) *
                      1e-6};
}

class LowpanCost : public testing::TestWithParam<bool> {};

TEST_P(LowpanCost, IsThatOfNs3) {
    for (const std::size_t octets :
         {1U, 39U, 100U, 101U, 102U, 103U, 104U, 105U, 106U, 107U, 120U, 200U, 212U, 300U, 519U}) {
        const RadioCost computed = radio_cost(Transport::udp, octets, GetParam());
        const RadioCost found = by_ns3(octets, GetParam());
        EXPECT_EQ(computed.frames, found.frames) << octets;
        EXPECT_NEAR(computed.air_ms, found.air_ms, 1e-6) << octets;
    }
}

INSTANTIATE_TEST_SUITE_P(ToOneAndToAll, LowpanCost, testing::Bool());

TEST(LowpanCostOfTcp, LeavesItsHeaderAsItIs) {
    // 32 octets in a segment with time stamps: 11 of MAC, 4 of IP, 32 of TCP, and 16 before frames.
    const RadioCost cost = radio_cost(Transport::tcp, 32 + 32, false);
    EXPECT_EQ(cost.frames, 1);
    EXPECT_NEAR(cost.air_ms, 0.032 * (6 + 11 + 4 + 64 + 6 + 5), 1e-9);
}

}  // namespace
}  // namespace romano::bench::ros::lowpan_cost_test
