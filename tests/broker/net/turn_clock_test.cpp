#include "broker/net/turn_clock.h"

#include <gtest/gtest.h>

#include <boost/asio/post.hpp>
#include <thread>

#include "broker/net/clock.h"
#include "broker/net/core_timer.h"

namespace romano::net::turn_clock_test {
namespace {

using namespace std::chrono_literals;

constexpr Instant start{1h};

struct Turns : testing::Test {
    void turn(Instant at, Duration took) {
        clock.begin(at);
        clock.begin(at + took / 2);  // another part of the same turn
        clock.end(at + took);
    }

    boost::asio::io_context io;
    TurnClock& clock = TurnClock::of(io);
};

TEST_F(Turns, TheLongestCountsFromItsFirstPartToItsEnd) {
    EXPECT_EQ(clock.longest(start), 0s);
    turn(start, 3ms);
    turn(start + 1s, 2ms);
    EXPECT_EQ(clock.longest(start + 2s), 3ms);
}

TEST_F(Turns, ALongOneIsRememberedForHalfAMinuteAtLeastAndForAMinuteAtMost) {
    turn(start, 1us);
    turn(start + 29s, 7ms);
    for (auto later = 30s; later < 59s; later += 1s) turn(start + later, 1us);
    EXPECT_EQ(clock.longest(start + 59s), 7ms);
    turn(start + 61s, 1us);
    EXPECT_EQ(clock.longest(start + 61s), 1us);
}

TEST_F(Turns, WhoDoesNothingForAMinuteHasNone) {
    turn(start, 7ms);
    EXPECT_EQ(clock.longest(start + 45s), 7ms);
    EXPECT_EQ(clock.longest(start + 61s), 0s);
    turn(start + 2h, 1ms);
    EXPECT_EQ(clock.longest(start + 2h), 1ms);
}

TEST_F(Turns, WaitingIsNoTurnAndATimersWorkIsOne) {
    CoreTimer timer(io, [] { std::this_thread::sleep_for(30ms); });
    timer.arm(now() + 200ms);
    const Instant began = now();
    run_in_turns(io);
    EXPECT_GE(clock.longest(now()), 30ms);
    EXPECT_LT(clock.longest(now()), now() - began - 150ms) << "it waited for 200 ms";
}

TEST_F(Turns, WhatAnotherThreadHadToSayIsOne) {
    std::thread([this] { post_turn(io, [] { std::this_thread::sleep_for(30ms); }); }).join();
    run_in_turns(io);
    EXPECT_GE(clock.longest(now()), 30ms);
}

}  // namespace
}  // namespace romano::net::turn_clock_test
