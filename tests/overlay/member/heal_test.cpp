// Brokers that meet again, and what one of them wrote meanwhile.

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "tests/overlay/member/brokers.h"
#include "tests/overlay/member/steps.h"

namespace romano::test::heal_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

/// Broker 1, with the robot "far", was cut off while "near", at another broker, published a lot.
struct Heal : testing::Test {
    Brokers brokers;
    const std::vector<std::string> all = numbers(1, 300);
    Robot* far = nullptr;
    Robot* near = nullptr;

    void publish_beyond_the_cut(int home) {
        start(brokers, {1, 2, 3});
        far = &subscriber(brokers, "far", 1, Qos::exactly_once);
        near = &subscriber(brokers, "near", home, Qos::exactly_once);
        brokers.cut(1, 2);
        brokers.cut(1, 3);
        brokers.run_for(settling);
        for (const auto& number : all) near->publish("pose", number, Qos::exactly_once);
        brokers.run_for(20s);
        ASSERT_EQ(near->received(), all);
        ASSERT_TRUE(far->received().empty());
    }
};

TEST_F(Heal, P2_ALogThatWentOnForLongIsCaughtUpWithPieceByPiece) {
    ASSERT_NO_FATAL_FAILURE(publish_beyond_the_cut(2));
    brokers.heal();
    brokers.run_for(5s);
    EXPECT_EQ(far->received(), all);
    EXPECT_EQ(far->rejections(), 0);
}

// Members let events go that all of them hold, and the one that was cut off is none.
TEST_F(Heal, P2_WhatABrokerWroteBeforeItDiedReachesOneThatWasCutOff) {
    ASSERT_NO_FATAL_FAILURE(publish_beyond_the_cut(3));
    brokers.heal();
    for (int ms = 0; ms < 1'000 && brokers.view_size(1) != 3; ++ms) brokers.run_for(1ms);
    ASSERT_EQ(brokers.view_size(1), 3U);
    brokers.kill(3);
    brokers.run_for(5s);
    EXPECT_EQ(far->received(), all);
    near->publish("pose", "last", Qos::exactly_once);
    brokers.run_for(settling);
    EXPECT_EQ(near->received().back(), "last");
    EXPECT_EQ(near->received().size(), all.size() + 1);
    expect_unnoticed(*near);
    expect_unnoticed(*far);
}

// It follows the logs where it left them, and these name messages of a log that it never held.
TEST(Member, P1_WhatWasPublishedAtABrokerThatCameAndDiedMeanwhileIsKeptForAbsentReceivers) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& receiver = brokers.robot("receiver", 2);
    receiver.connect(false);
    receiver.subscribe("pose", Qos::at_least_once);
    brokers.run_for(200ms);
    receiver.disconnect();
    brokers.run_for(settling);
    brokers.stall(3);
    brokers.run_for(settling);

    start(brokers, {4});
    Robot& robot = publisher(brokers, "robot", 4);
    for (const auto& text : numbers(1, 5)) robot.publish("pose", text, Qos::at_least_once);
    brokers.run_for(settling);
    ASSERT_EQ(robot.acknowledged(), 5U);
    brokers.kill(4);
    brokers.run_for(settling);

    brokers.wake_slowly(3, 1);
    brokers.run_for(3s);
    brokers.kill(1);
    brokers.kill(2);
    brokers.run_for(settling);
    receiver.connect(false);
    brokers.run_for(settling);
    EXPECT_EQ(receiver.received(), numbers(1, 5));
}

// Clients that it calls as the cut ends would hear both sides until these hear each other.
TEST(AddressesAfterACut, I7_TheSmallerSideDoesNotCallItsClientsAgain) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    brokers.cut(1, 3);
    brokers.cut(2, 3);
    brokers.run_for(settling);
    ASSERT_EQ(brokers.member(3).cluster().addresses().serving().size(), 3U);
    const int heir = brokers.member(1).cluster().addresses().serving().size() > 1 ? 1 : 2;
    for (const int address : {1, 2, 3}) {
        EXPECT_FALSE(brokers.member(3).may_announce(broker_address(address)));
        EXPECT_TRUE(brokers.member(heir).may_announce(broker_address(address)));
    }
    brokers.heal();
    brokers.run_for(settling);
    EXPECT_TRUE(brokers.member(3).may_announce(broker_address(3)));
}

// The machine that had the address may be alive without its broker.
TEST(AddressesAfterACut, WhoOutlivedAllOthersCallsTheirClientsAgain) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    brokers.leave(1);
    brokers.leave(2);
    brokers.run_for(settling);
    ASSERT_EQ(brokers.member(3).cluster().addresses().serving().size(), 3U);
    EXPECT_TRUE(brokers.member(3).may_announce(broker_address(1)));
}

}  // namespace
}  // namespace romano::test::heal_test
