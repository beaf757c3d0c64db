// The timers of all sessions: the earliest first, and moving one later costs nothing.

#include "broker/core/deadlines.h"

#include <gtest/gtest.h>

#include <map>

#include "romano/base/random.h"

namespace romano::broker::deadlines_test {
namespace {

TEST(Deadlines, ComeInOrderOfTimeThenNumber) {
    Deadlines deadlines;
    deadlines.no_later_than(3, Instant{Duration{20}});
    deadlines.no_later_than(2, Instant{Duration{10}});
    deadlines.no_later_than(1, Instant{Duration{20}});
    EXPECT_EQ(deadlines.next(), Instant{Duration{10}});
    EXPECT_EQ(deadlines.pop(), 2u);
    EXPECT_EQ(deadlines.pop(), 1u);
    EXPECT_EQ(deadlines.pop(), 3u);
    EXPECT_EQ(deadlines.next(), never);
}

TEST(Deadlines, MoveEarlierButNotLater) {
    Deadlines deadlines;
    deadlines.no_later_than(1, Instant{Duration{20}});
    deadlines.no_later_than(1, Instant{Duration{30}});
    EXPECT_EQ(deadlines.next(), Instant{Duration{20}});
    deadlines.no_later_than(1, Instant{Duration{10}});
    EXPECT_EQ(deadlines.next(), Instant{Duration{10}});
    EXPECT_EQ(deadlines.size(), 1u);
}

TEST(Deadlines, AgreeWithASortedTable) {
    Random random{3};
    Deadlines deadlines;
    std::map<Deadlines::Number, Instant> model;
    for (int step = 0; step < 20'000; ++step) {
        const Deadlines::Number number = random.below(200);
        const Instant at{Duration{random.below(1000)}};
        if (random.below(4) == 0) {
            deadlines.remove(number);
            model.erase(number);
        } else {
            deadlines.no_later_than(number, at);
            const auto [place, is_new] = model.try_emplace(number, at);
            if (!is_new) place->second = std::min(place->second, at);
        }
        ASSERT_EQ(deadlines.size(), model.size());
        Instant earliest = never;
        for (const auto& [who, when] : model) earliest = std::min(earliest, when);
        ASSERT_EQ(deadlines.next(), earliest);
        if (random.below(5) == 0 && !model.empty()) {
            const Deadlines::Number popped = deadlines.pop();
            ASSERT_EQ(model.at(popped), earliest);
            model.erase(popped);
        }
    }
}

}  // namespace
}  // namespace romano::broker::deadlines_test
