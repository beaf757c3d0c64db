// Brokers that meet again, and what one of them wrote meanwhile.

#include <gmock/gmock.h>

#include "tests/overlay/member/brokers.h"
#include "tests/overlay/member/steps.h"

namespace romano::test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

TEST(Heal, P2_ALogThatWentOnForLongIsCaughtUpWithPieceByPiece) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& far = subscriber(brokers, "far", 1, Qos::exactly_once);
    Robot& near = subscriber(brokers, "near", 2, Qos::exactly_once);
    brokers.cut(1, 2);
    brokers.cut(1, 3);
    brokers.run_for(settling);
    const auto all = numbers(1, 300);
    for (const auto& number : all) near.publish("pose", number, Qos::exactly_once);
    brokers.run_for(20s);
    ASSERT_EQ(near.received(), all);
    ASSERT_TRUE(far.received().empty());
    brokers.heal();
    brokers.run_for(5s);
    EXPECT_EQ(far.received(), all);
    EXPECT_EQ(far.rejections(), 0);
}

// Members let events go that all of them hold, and the one that was cut off is none.
TEST(Heal, P2_WhatABrokerWroteBeforeItDiedReachesOneThatWasCutOff) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& far = subscriber(brokers, "far", 1, Qos::exactly_once);
    Robot& near = subscriber(brokers, "near", 3, Qos::exactly_once);
    brokers.cut(1, 2);
    brokers.cut(1, 3);
    brokers.run_for(settling);
    const auto all = numbers(1, 300);
    for (const auto& number : all) near.publish("pose", number, Qos::exactly_once);
    brokers.run_for(20s);
    ASSERT_EQ(near.received(), all);
    brokers.heal();
    for (int ms = 0; ms < 1'000 && brokers.view_size(1) != 3; ++ms) brokers.run_for(1ms);
    ASSERT_EQ(brokers.view_size(1), 3U);
    brokers.kill(3);
    brokers.run_for(5s);
    EXPECT_EQ(far.received(), all);
    near.publish("pose", "last", Qos::exactly_once);
    brokers.run_for(settling);
    EXPECT_EQ(near.received().back(), "last");
    EXPECT_EQ(near.received().size(), all.size() + 1);
    expect_unnoticed(near);
    expect_unnoticed(far);
}

}  // namespace
}  // namespace romano::test
