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

}  // namespace
}  // namespace romano::cluster::log_answers_test
