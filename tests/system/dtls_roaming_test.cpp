// Our own clients of DTLS behind a box that changes their address: they go on by their Connection
// ID (RFC 9146) without a handshake, and a broker that stands in knows them, too.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/system/dtls_fleet.h"
#include "tests/system/small_nat.h"

namespace romano::system::dtls_roaming_test {
namespace {

using testing::HasSubstr;

struct RoamingFleet : DtlsFleet {
    std::unique_ptr<SmallNat> nat_to(int broker) {
        return std::make_unique<SmallNat>(addresses.service_endpoint(100), addresses.client(),
                                          addresses.service_endpoint(broker));
    }
    /// What clients that sit behind it take for the broker.
    static constexpr int nat = 100;
    static constexpr const char* moved = "romano_dtls_moved_total";
};

TEST_F(RoamingFleet, ARobotGoesOnFromAnotherAddress) {
    start_protected(1, {"--retry-ms", "1000", "--retries", "20"});
    const auto box = nat_to(1);
    const auto robot = robot_at(nat, "1");
    EXPECT_THAT(robot->wait_for("established"), HasSubstr("abcd1234"));
    for (const std::string way : {"front", "back"}) {
        box->move();
        EXPECT_EQ(romano(at(1, "anna", {"move", "abcd1234", way, "100mm"})), 0) << said;
        EXPECT_THAT(robot->wait_for(way + " 100 mm"), HasSubstr(way));
    }
    EXPECT_TRUE(comes_to_say(1, moved, "2"));
    EXPECT_TRUE(comes_to_say(1, handshakes, "3")) << "the robot's, and two of anna's programs";
    EXPECT_TRUE(comes_to_say(1, "romano_sessions{state=\"active\"}", "1"));
}

TEST_F(RoamingFleet, NothingIsLostOrRepeatedWhereTheAddressChangesAndTheBrokerIsKilled) {
    start_member(1, {"--retry-ms", "1000", "--retries", "20"});
    start_member(2, {"--retry-ms", "1000", "--retries", "20", "--listen", addresses.service(3)});
    expect_both_in_view();
    const auto box = nat_to(1);
    Process listener(ROMANO_PROGRAM,
                     at(nat, "anna", {"sub", "-t", "number", "-q", "2", "-C", "80", "-k", "1"}));
    TestClient publisher(addresses.client(), addresses.service_endpoint(3), "somebody");
    ASSERT_TRUE(publisher.connect());
    const auto topic = publisher.register_topic("number");
    ASSERT_TRUE(topic);
    // Retained, because nobody says when it has subscribed.
    ASSERT_TRUE(publisher.publish(*topic, "0", mqttsn::Qos::exactly_once, true));
    ASSERT_EQ(listener.next_line(), "0");
    auto publish_until = [&, next = 1](int end) mutable {
        for (; next < end; ++next) {
            ASSERT_TRUE(publisher.publish(*topic, std::to_string(next), mqttsn::Qos::exactly_once))
                << next;
        }
    };
    publish_until(20);
    box->move();
    publish_until(40);
    box->move();
    brokers[0]->kill_9();
    publish_until(60);
    box->move();
    publish_until(80);
    for (int i = 1; i < 80; ++i) ASSERT_EQ(listener.next_line(), std::to_string(i));
    EXPECT_EQ(listener.wait_for_exit(), 0);
    EXPECT_EQ(metric(2, handshakes), "0");
    EXPECT_GE(std::stoi(metric(2, moved)), 1);
}

}  // namespace
}  // namespace romano::system::dtls_roaming_test
