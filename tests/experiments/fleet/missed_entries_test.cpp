#include "experiments/fleet/missed_entries.h"

#include <gtest/gtest.h>

namespace romano::experiments::missed_entries_test {
namespace {

using namespace std::chrono_literals;

constexpr Instant start{1h};

message::RomanoId robot(int number) {
    char text[9];
    std::snprintf(text, sizeof text, "%08x", static_cast<unsigned>(number));
    return *message::RomanoId::parse(text);
}

struct Entries : testing::Test {
    void come(Instant at, int count, bool is_answer = false) {
        for (int n = 0; n < count; ++n) missed.on_entry(at, robot(n), is_answer);
    }

    MissedEntries missed;
};

TEST_F(Entries, AreAskedForAgainOnceABurstIsOver) {
    come(start, 500);
    EXPECT_FALSE(missed.asks(start + 900ms));
    come(start + 900ms, 1);
    EXPECT_FALSE(missed.asks(start + 1800ms));
    EXPECT_TRUE(missed.asks(start + 1900ms));
    EXPECT_FALSE(missed.asks(start + 1h)) << "the broker has not answered";
}

TEST_F(Entries, AreNotAskedForAgainWhenFewCame) {
    for (int n = 0; n < 1000; ++n) {
        come(start + n * 2s, 50);
        EXPECT_FALSE(missed.asks(start + n * 2s + 1s));
    }
}

TEST_F(Entries, AreAskedForAgainEachHalfMinuteWhileTheyAlwaysCome) {
    int asked = 0;
    for (auto at = 0ms; at < 95s; at += 100ms) {
        come(start + at, 20);
        if (!missed.asks(start + at)) continue;
        ++asked;
        missed.on_subscribed(start + at);
        EXPECT_TRUE(missed.is_answered(start + at + 5s));
    }
    EXPECT_EQ(asked, 3);
}

TEST_F(Entries, OfTheAnswerAreNoBurst) {
    missed.on_subscribed(start);
    come(start, 10'000, true);
    EXPECT_TRUE(missed.is_answered(start + 5s));
    EXPECT_FALSE(missed.asks(start + 10s));
}

TEST_F(Entries, ThatTheAnswerDoesNotHaveAreOfRobotsThatHaveLeft) {
    missed.on_subscribed(start);
    come(start + 4s, 2, true);
    missed.on_entry(start + 8s, robot(7), false);
    EXPECT_FALSE(missed.is_answered(start + 8900ms)) << "five seconds after its last entry";
    EXPECT_TRUE(missed.is_answered(start + 9s));
    EXPECT_FALSE(missed.is_answered(start + 9s)) << "once";
    EXPECT_TRUE(missed.was_told(robot(1)));
    EXPECT_TRUE(missed.was_told(robot(7))) << "it came meanwhile";
    EXPECT_FALSE(missed.was_told(robot(2)));
}

}  // namespace
}  // namespace romano::experiments::missed_entries_test
