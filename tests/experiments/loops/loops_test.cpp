// Loops in virtual time: poles far on either side of the margin, and broken brokers.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "experiments/loops/balance.h"
#include "experiments/loops/deviation.h"
#include "experiments/loops/formation.h"
#include "experiments/loops/margins.h"
#include "experiments/loops/radio_brokers.h"
#include "overlay/sim/seed.h"

namespace romano::experiments::loops_test {
namespace {

using namespace std::chrono_literals;

const CartPoleBody body;

TEST(Balance, APoleStandsWellInsideTheMarginAndFallsWellOutside) {
    for (const std::uint64_t seed : {1, 2, 3}) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const BalanceRun inside = balance(body, {.delay = 60ms, .loss = 0.1, .seed = seed});
        EXPECT_TRUE(inside.stays_up);
        EXPECT_NEAR(inside.samples, 1'000, 5);
        EXPECT_NEAR(inside.commands, 900, 60);
        EXPECT_NEAR(inside.greatest_delay_s, 0.060, 0.001);
        const BalanceRun outside = balance(body, {.delay = 140ms, .loss = 0.1, .seed = seed});
        EXPECT_FALSE(outside.stays_up);
        EXPECT_LT(outside.stood_s, 20);
    }
}

TEST(Balance, ASeedGivesTheSameRunAgain) {
    const BalanceCase some{.delay = 97ms, .loss = 0.2, .seed = 11};
    const BalanceRun once = balance(body, some);
    const BalanceRun again = balance(body, some);
    EXPECT_EQ(once.stays_up, again.stays_up);
    EXPECT_EQ(once.stood_s, again.stood_s);
    EXPECT_EQ(once.commands, again.commands);
}

TEST(Margins, WhatIsFoundWithoutLossesIsWhatTheTheorySays) {
    MarginsPlan plan;
    plan.seconds = 10;
    const Column column = column_of(plan, 40, 0);
    ASSERT_TRUE(column.found_ms());
    EXPECT_NEAR(*column.found_ms(), column.mean_square_ms, 2);
    EXPECT_TRUE(std::ranges::is_sorted(column.trials, {}, &Trial::delay_ms));
}

TEST(Margins, APeriodWithTooShortAWindowGetsOneSentence) {
    MarginsPlan plan;
    EXPECT_FALSE(problem_with(plan));
    plan.periods_ms = {20, 6};
    EXPECT_EQ(problem_with(plan),
              "a period of 6 ms is too short: the delays that are tried, up to 200 ms, must be "
              "below 31 periods");
}

TEST(Deviation, APoleFallsWithItsOnlyBrokerAndNotWithOneOfThree) {
    const DeviationRun calm = deviate(body, {.brokers = 3, .fault = BrokerFault::none, .seed = 5});
    ASSERT_TRUE(calm.angle_deg);
    EXPECT_EQ(calm.lost, 0U);
    EXPECT_LT(calm.age_ms, 26);  // P + D
    const DeviationRun crash =
        deviate(body, {.brokers = 3, .fault = BrokerFault::crash, .seed = 5});
    ASSERT_TRUE(crash.angle_deg);
    EXPECT_EQ(crash.falls_back, 0U);
    EXPECT_LE(crash.lost, 2U);
    const DeviationRun alone =
        deviate(body, {.brokers = 1, .fault = BrokerFault::crash, .seed = 5});
    EXPECT_FALSE(alone.angle_deg);
    EXPECT_EQ(alone.falls_back, 1U);
    EXPECT_LE(alone.age_ms, deadline_ms_for(LoopWorld::simulated, 20) + 0.001);  // romano/control
}

TEST(Deviation, OnRadioAPoleFallsWithItsOnlyBrokerAndNotWithOneOfThreeNorWhenItRoams) {
    if (!has_radio) GTEST_SKIP() << "no ns-3";
    const LoopGround radio{.world = LoopWorld::radio};
    const auto on_radio = [&](std::size_t brokers, BrokerFault fault) {
        return deviate(body, {.ground = radio, .brokers = brokers, .fault = fault, .seed = 5});
    };
    const DeviationRun calm = on_radio(3, BrokerFault::none);
    ASSERT_TRUE(calm.angle_deg);
    EXPECT_EQ(calm.falls_back, 0U);
    EXPECT_GT(calm.age_ms, 20 + 25);  // P + D: four times the way between a robot and a broker
    const DeviationRun crash = on_radio(3, BrokerFault::crash);
    EXPECT_TRUE(crash.angle_deg);
    EXPECT_EQ(crash.falls_back, 0U);
    const DeviationRun roams = on_radio(3, BrokerFault::roaming);
    EXPECT_TRUE(roams.angle_deg);
    EXPECT_EQ(roams.falls_back, 0U);
    const DeviationRun alone = on_radio(1, BrokerFault::crash);
    EXPECT_FALSE(alone.angle_deg);
    EXPECT_EQ(alone.falls_back, 1U);
    EXPECT_LE(alone.age_ms, deadline_ms_for(LoopWorld::radio, 20) + 0.001);
}

/// In this run the heir of its robots finds it 87 ms after the leader has. It was in the view by
/// then, and the heir silent: the cell's queues filled, and the pole fell.
TEST(Deviation, OnRadioABrokerThatComesBackInterruptsNoLoop) {
    if (!has_radio) GTEST_SKIP() << "no ns-3";
    const DeviationRun back = deviate(body, {.ground = {.world = LoopWorld::radio},
                                             .brokers = 5,
                                             .fault = BrokerFault::crash,
                                             .seed = sim::seed_of(1, "deviation", 2)});
    EXPECT_TRUE(back.angle_deg);
    EXPECT_EQ(back.falls_back, 0U);
    EXPECT_LT(back.wait_ms.value_or(1'000), 100);
}

/// In this run all answers to the plant's invitations come too late, and it gives the loop up.
TEST(Deviation, ALoopThatWasGivenUpAtItsBeginningIsOpenedAgain) {
    if (!has_radio) GTEST_SKIP() << "no ns-3";
    EXPECT_NO_THROW((void)deviate(body, {.ground = {.world = LoopWorld::radio},
                                         .brokers = 3,
                                         .fault = BrokerFault::none,
                                         .seed = sim::seed_of(1, "deviation", 20)}));
}

TEST(Deviation, WhereThereCanBeNoLoopOneSentenceSaysWhy) {
    EXPECT_EQ(problem_with(LoopGround{}), "");
    EXPECT_EQ(problem_with({.world = LoopWorld::processes, .broker_program = "/none"}),
              "--worlds processes: no broker to run: `/none` is no program; build romano-broker, "
              "or name it with --broker");
    EXPECT_EQ(problem_with({.world = LoopWorld::radio}).empty(), has_radio);
}

TEST(Formation, ALawPutsAFollowerInItsPlaceAndKeepsItThere) {
    const WedgePlace place{-300, 200};
    const firmware::Speed speed{200, 15};
    firmware::Body leader;
    firmware::Body follower{{-100, -100, 40}};
    for (int i = 0; i < 1'000; ++i) {
        follower.go_on(speed_to_place(leader.pose(), speed, place, follower.pose()), 0.01);
        leader.go_on(speed, 0.01);
    }
    const firmware::Pose wanted = place_at(leader.pose(), place);
    EXPECT_NEAR(follower.pose().x_mm, wanted.x_mm, 10);
    EXPECT_NEAR(follower.pose().y_mm, wanted.y_mm, 10);
}

TEST(Formation, OnRadioFourLoopsHaveRoomAndSurviveACrash) {
    if (!has_radio) GTEST_SKIP() << "no ns-3";
    const FormationRun run = formation({.world = LoopWorld::radio}, 3, BrokerFault::crash, 5);
    EXPECT_EQ(run.falls_back, 0U);
    EXPECT_LT(run.error_mm, 25);
}

TEST(Formation, BreaksUpWithItsOnlyBrokerAndNotWithOneOfThree) {
    const FormationRun whole = formation({}, 3, BrokerFault::crash, 5);
    EXPECT_EQ(whole.falls_back, 0U);
    const FormationRun alone = formation({}, 1, BrokerFault::crash, 5);
    EXPECT_EQ(alone.falls_back, 4U);
    EXPECT_GT(alone.error_mm, 5 * whole.error_mm);
}

}  // namespace
}  // namespace romano::experiments::loops_test
