#include "experiments/load/arrivals.h"

#include <gtest/gtest.h>

namespace romano::experiments::arrivals_test {
namespace {

TEST(Arrivals, ACopyIsADuplicateHoweverLateItComes) {
    Arrivals arrivals{1, 1};
    for (std::uint32_t i = 0; i < 1000; ++i) EXPECT_TRUE(arrivals.note(0, 0, i));
    EXPECT_FALSE(arrivals.note(0, 0, 0));
    EXPECT_EQ(arrivals.delivered(), 1000U);
    EXPECT_EQ(arrivals.duplicates(), 1U);
    EXPECT_EQ(arrivals.out_of_order(), 0U);
}

TEST(Arrivals, AMessageBehindALaterOneIsOutOfOrderAndDelivered) {
    Arrivals arrivals{1, 1};
    for (const std::uint32_t sequence : {0U, 2U, 1U, 3U}) arrivals.note(0, 0, sequence);
    EXPECT_EQ(arrivals.delivered(), 4U);
    EXPECT_EQ(arrivals.out_of_order(), 1U);
}

TEST(Arrivals, StreamsAndReceiversAreApart) {
    Arrivals arrivals{2, 2};
    EXPECT_TRUE(arrivals.note(0, 0, 5));
    EXPECT_TRUE(arrivals.note(0, 1, 5));
    EXPECT_TRUE(arrivals.note(1, 0, 5));
    EXPECT_FALSE(arrivals.note(1, 0, 5));
    EXPECT_EQ(arrivals.delivered(), 3U);
}

TEST(Arrivals, AMessageIsWithThoseToWhomItCame) {
    Arrivals arrivals{1, 3};
    for (const std::uint32_t receiver : {0U, 2U, 2U, 1U}) arrivals.note(0, receiver, 0);
    arrivals.note(0, 0, 70);
    EXPECT_EQ(arrivals.receivers_having(0, 0), 3U);
    EXPECT_EQ(arrivals.receivers_having(0, 70), 1U);
}

}  // namespace
}  // namespace romano::experiments::arrivals_test
