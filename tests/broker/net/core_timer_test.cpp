#include "broker/net/core_timer.h"

#include <gtest/gtest.h>

#include "broker/net/clock.h"

namespace romano::net::core_timer_test {
namespace {

using namespace std::chrono_literals;

TEST(CoreTimer, WakesAtTheDeadlineAndNotBefore) {
    boost::asio::io_context io;
    Instant woken{};
    CoreTimer timer(io, [&] { woken = now(); });
    const Instant deadline = now() + 5ms;
    timer.arm(deadline);
    io.run();
    EXPECT_GE(woken, deadline);
}

// Between two clocks that are read one after the other this thread may lose its processor. A timer
// of the one that ends before the other one's deadline would wake nobody.
TEST(Clock, AnInstantIsNotTooEarlyOnTheSteadyClock) {
    for (int i = 0; i < 100'000; ++i) {
        const auto before = std::chrono::steady_clock::now();
        const Instant deadline = now() + 10ms;
        ASSERT_GE(to_steady_clock(deadline), before + 10ms);
    }
}

TEST(CoreTimer, MovesForwardToAnEarlierDeadline) {
    boost::asio::io_context io;
    int wakeups = 0;
    CoreTimer timer(io, [&] { ++wakeups; });
    const Instant start = now();
    timer.arm(start + 1h);
    timer.arm(start + 2ms);
    io.run();
    EXPECT_EQ(wakeups, 1);
}

TEST(CoreTimer, StaysWithAnEarlierDeadlineWhenItMovesBack) {
    boost::asio::io_context io;
    int wakeups = 0;
    CoreTimer timer(io, [&] { ++wakeups; });
    timer.arm(now() + 2ms);
    timer.arm(now() + 1h);
    io.run();  // would take an hour
    EXPECT_EQ(wakeups, 1);
}

TEST(CoreTimer, CanBeArmedAgainFromItsWakeUp) {
    boost::asio::io_context io;
    int wakeups = 0;
    CoreTimer* self = nullptr;
    CoreTimer timer(io, [&] {
        if (++wakeups < 3) self->arm(now() + 1ms);
    });
    self = &timer;
    timer.arm(now());
    io.run();
    EXPECT_EQ(wakeups, 3);
}

TEST(CoreTimer, CountsHowLateItWoke) {
    boost::asio::io_context io;
    CoreTimer timer(io, [] {});
    timer.arm(now() - 30ms);
    io.run();
    EXPECT_GE(timer.delays().sum(), 30ms);
}

TEST(CoreTimer, AtOnceIsNeverLate) {
    boost::asio::io_context io;
    CoreTimer timer(io, [] {});
    timer.arm(Instant::min());
    io.run();
    EXPECT_EQ(timer.delays().sum(), 0ms);
}

TEST(CoreTimer, NeverIsNoDeadline) {
    boost::asio::io_context io;
    CoreTimer timer(io, [] { FAIL(); });
    timer.arm(never);
    io.run();  // nothing to wait for
}

}  // namespace
}  // namespace romano::net::core_timer_test
