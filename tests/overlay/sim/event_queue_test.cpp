#include "overlay/sim/event_queue.h"

#include <gtest/gtest.h>

#include <string>

#include "overlay/sim/local_clock.h"
#include "overlay/sim/seed.h"

namespace romano::sim::event_queue_test {
namespace {

using namespace std::chrono_literals;

TEST(EventQueue, RunsByTimeThenByTheOrderOfAsking) {
    EventQueue queue;
    std::string order;
    queue.after(2ms, [&] { order += 'c'; });
    queue.after(1ms, [&] { order += 'a'; });
    queue.after(1ms, [&] { order += 'b'; });
    queue.run_for(10ms);
    EXPECT_EQ(order, "abc");
    EXPECT_EQ(queue.now(), Instant{10ms});
}

TEST(EventQueue, AnEventMayAskForMore) {
    EventQueue queue;
    int ticks = 0;
    std::function<void()> tick = [&] {
        ++ticks;
        queue.after(10ms, tick);
    };
    queue.after(10ms, tick);
    queue.run_for(95ms);
    EXPECT_EQ(ticks, 9);
}

TEST(LocalClock, WhenReachesItAndIsNotLate) {
    for (const std::int64_t drift : {-100, -1, 0, 1, 100}) {
        const LocalClock clock(3h, drift);
        for (const Duration t : {Duration{0}, Duration{1ns}, Duration{7s + 123ns}, Duration{2h}}) {
            const Instant local = clock.at(Instant{t});
            const Instant when = clock.when(local);
            EXPECT_GE(clock.at(when), local);
            EXPECT_LT(clock.at(when - 1us), local);
        }
    }
}

TEST(SeedOf, PartsAndNumbersHaveTheirOwnStreams) {
    EXPECT_NE(seed_of(1, "robot", 0), seed_of(1, "robot", 1));
    EXPECT_NE(seed_of(1, "robot", 0), seed_of(2, "robot", 0));
    EXPECT_NE(seed_of(1, "robot", 0), seed_of(1, "broker", 0));
}

}  // namespace
}  // namespace romano::sim::event_queue_test
