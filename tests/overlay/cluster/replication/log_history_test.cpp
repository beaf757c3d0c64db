#include "overlay/cluster/replication/log_history.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::log_history_test {
namespace {

using test::published;
using test::session;

const LogId log = test::log_of("b1");

constexpr Duration kept_on{1'000'000};

LogHistory history_of(Seq events, std::size_t most) {
    LogHistory history(most);
    for (Seq seq = 1; seq <= events; ++seq) history.append(published(log, seq));
    return history;
}

TEST(LogHistory, GivesTheEventsAfterAPosition) {
    const LogHistory history = history_of(5, 100);
    EXPECT_EQ(history.last(), 5U);
    EXPECT_EQ(history.events_after(2, 100).size(), 3U);
    EXPECT_EQ(history.events_after(2, 2).size(), 2U);
    EXPECT_TRUE(history.events_after(5, 100).empty());
}

TEST(LogHistory, P8_BeyondItsBoundTheOldestGo) {
    const LogHistory history = history_of(10, 4);
    EXPECT_EQ(history.events_kept(), 4U);
    EXPECT_EQ(history.publishes_after(0).size(), 4U);
    EXPECT_TRUE(history.reaches_back_to(6));
    EXPECT_FALSE(history.reaches_back_to(5));
}

TEST(LogHistory, EventsAndPublishesAreForgottenApart) {
    LogHistory history = history_of(10, 100);
    history.forget_events(8);
    EXPECT_EQ(history.events_kept(), 2U);
    EXPECT_EQ(history.publishes_after(0).size(), 10U);
    history.forget_publishes(Instant{}, kept_on, 3);
    history.forget_publishes(Instant{kept_on}, kept_on, 3);
    EXPECT_EQ(history.publishes_after(0).size(), 7U);
    EXPECT_FALSE(history.publish_at(3));
    EXPECT_TRUE(history.publish_at(4));
}

TEST(LogHistory, P2_PublishesStayForAWhileAfterAllCursorsPassedThem) {
    LogHistory history = history_of(10, 100);
    const Duration step = kept_on / 4;
    for (Seq i = 0; i < 4; ++i) history.forget_publishes(Instant{} + i * step, kept_on, 3 + i);
    EXPECT_EQ(history.publishes_after(0).size(), 10U);
    history.forget_publishes(Instant{kept_on}, kept_on, 10);
    EXPECT_EQ(history.publishes_after(0).size(), 7U);
}

// A broker that knows nobody yet says that all have passed everything.
TEST(LogHistory, P2_WhatWasPassedBeforeItWasPublishedStaysAsLong) {
    LogHistory history(100);
    history.forget_publishes(Instant{}, kept_on, std::numeric_limits<Seq>::max());
    for (Seq seq = 1; seq <= 10; ++seq) history.append(published(log, seq));
    history.forget_publishes(Instant{kept_on}, kept_on, 10);
    EXPECT_EQ(history.publishes_after(0).size(), 10U);
}

// While a dead broker's log is kept nobody passes anything; then all of it may go.
TEST(LogHistory, ManyAreForgottenInPieces) {
    constexpr Seq most = LogHistory::most_at_once;
    constexpr Seq due = 16 * most;
    LogHistory history = history_of(due + 10, 2 * due);
    EXPECT_FALSE(history.forget_events(due));
    EXPECT_EQ(history.events_kept(), due + 10 - most);
    EXPECT_TRUE(history.forget_publishes(Instant{}, kept_on, due)) << "none goes yet";
    EXPECT_FALSE(history.forget_publishes(Instant{kept_on}, kept_on, due));
    EXPECT_EQ(history.publishes_after(0).size(), due + 10 - most);

    int turns = 1;
    while (!history.forget_events(due)) ASSERT_LT(++turns, 100);
    EXPECT_EQ(history.events_kept(), 10U);
    while (!history.forget_all()) ASSERT_LT(++turns, 100);
    EXPECT_EQ(history.publishes_after(0).size(), 0U);
}

// A tenth of a second under full load: freed in one turn it keeps a beacon waiting.
TEST(LogHistory, I8_AFewThousandAreForgottenInManyTurns) {
    constexpr Seq due = 3'200;
    LogHistory history = history_of(due + 10, due + 10);
    (void)history.forget_publishes(Instant{}, kept_on, due);
    std::size_t turns = 0;
    bool is_all = false;
    while (!is_all) {
        const std::size_t events = history.events_kept();
        const std::size_t publishes = history.publishes_after(0).size();
        is_all = history.forget_events(due);
        is_all &= history.forget_publishes(Instant{kept_on}, kept_on, due);
        EXPECT_LE(events - history.events_kept(), 400U);
        EXPECT_LE(publishes - history.publishes_after(0).size(), 400U);
        ASSERT_LE(++turns, 16U) << "and not in many more";
    }
    EXPECT_GE(turns, 8U);
    EXPECT_EQ(history.events_kept(), 10U);
    EXPECT_EQ(history.publishes_after(0).size(), 10U);
}

TEST(LogHistory, OnlyPublishesAreKeptAsPublishes) {
    LogHistory history(100);
    history.append(session("robot"));
    history.append(published(log, 2));
    EXPECT_EQ(history.publishes_after(0).size(), 1U);
    EXPECT_FALSE(history.publish_at(1));
}

TEST(LogHistory, GoesOnAfterASnapshot) {
    LogHistory history(100);
    const auto kept = std::get<broker::Published>(published(log, Seq{7})).message;
    history.restart(9, {kept});
    EXPECT_EQ(history.last(), 9U);
    EXPECT_TRUE(history.reaches_back_to(9));
    EXPECT_FALSE(history.reaches_back_to(8));
    history.append(session("robot"));
    EXPECT_EQ(history.events_after(9, 10).size(), 1U);
    EXPECT_EQ(history.publish_at(7), kept);
}

}  // namespace
}  // namespace romano::cluster::log_history_test
