// What a broker says about a peer's log, and when.

#include <gtest/gtest.h>

#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::log_answers_test {
namespace {

using namespace two_brokers;

class LogAnswers : public testing::Test {
protected:
    LogAnswers() {
        for (int i = 0; i < 5; ++i) cluster.hear();
        cluster.peers.clear();
    }
    void take(Seq seq, bool awaited) {
        cluster.take(LogBatch{.log = peer,
                              .first_seq = seq,
                              .events = {test::published(peer, seq)},
                              .awaited = awaited});
    }

    Cluster cluster;
};

TEST_F(LogAnswers, WhatClientsWaitForIsAcknowledgedAtOnce) {
    take(1, true);
    const auto acks = cluster.take_sent<LogAck>();
    ASSERT_EQ(acks.size(), 1U);
    EXPECT_EQ(acks[0].through, (LogPosition{peer, 1}));
}

TEST_F(LogAnswers, WhatNobodyWaitsForIsAcknowledgedByTheBeacon) {
    take(1, false);
    EXPECT_TRUE(cluster.take_sent<LogAck>().empty());
    cluster.pass();
    EXPECT_EQ(cluster.core.beacon(cluster.broker).applied_through(peer), 1U);
}

TEST_F(LogAnswers, AnAcknowledgementCountsForAllBefore) {
    take(1, false);
    take(2, true);
    const auto acks = cluster.take_sent<LogAck>();
    ASSERT_EQ(acks.size(), 1U);
    EXPECT_EQ(acks[0].through, (LogPosition{peer, 2}));
}

// P3: an earlier life's log had as many events.
TEST_F(LogAnswers, AnAcknowledgementOfAnEarlierLifesLogMakesNothingSafe) {
    ViewAnnouncement announcement{
        .view = {.number = {100, self.broker, 1}, .members = {self, peer}}};
    std::ranges::sort(announcement.view.members);
    while (!cluster.core.leadership().leader) cluster.hear();
    cluster.take(announcement);
    for (int i = 0; i < 20; ++i) cluster.hear();
    cluster.core.append(1, test::published(self, 1));
    const auto safe_after = [this](const LogId& log) {
        cluster.take(LogAck{{log, 1}, peer});
        return cluster.core.safe(cluster.now);
    };
    EXPECT_EQ(safe_after(test::log_of("self", 0)), 0U);
    EXPECT_EQ(safe_after(self), 1U);
}

}  // namespace
}  // namespace romano::cluster::log_answers_test
