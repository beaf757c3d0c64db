#include "overlay/cluster/replication/own_log.h"

#include <gtest/gtest.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::own_log_test {
namespace {

const LogId self = test::log_of("b1");
const BrokerId peer = test::log_of("b2").broker;

OwnLog log_of(Seq events, std::size_t events_kept = 100'000) {
    OwnLog log(self, events_kept);
    for (Seq seq = 1; seq <= events; ++seq) log.append(seq, test::published(self, seq));
    return log;
}

LogEvent note() {
    return broker::DeliveryEnded{.client_id = "robot", .message = {test::log_of("b2"), 1}};
}

std::vector<LogBatch> flushed(OwnLog& log, Seq awaited = 0) {
    Outbox out;
    log.flush(awaited, out);
    std::vector<LogBatch> batches;
    for (auto& outgoing : out) {
        EXPECT_EQ(outgoing.to, std::nullopt);
        batches.push_back(std::get<LogBatch>(outgoing.message));
    }
    return batches;
}

TEST(OwnLog, APublishLeavesAtOnceAndIsAwaited) {
    OwnLog log = log_of(1);
    const auto batches = flushed(log);
    ASSERT_EQ(batches.size(), 1U);
    EXPECT_EQ(batches[0].first_seq, 1U);
    EXPECT_TRUE(batches[0].awaited);
    EXPECT_TRUE(flushed(log).empty()) << "once";
}

TEST(OwnLog, ANoteThatNobodyWaitsForLeavesWithTheBeacon) {
    OwnLog log = log_of(0);
    log.append(1, note());
    EXPECT_TRUE(flushed(log).empty());
    log.accompany_beacon();
    const auto batches = flushed(log);
    ASSERT_EQ(batches.size(), 1U);
    EXPECT_EQ(batches[0].events.size(), 1U);
    EXPECT_FALSE(batches[0].awaited);
    log.append(2, note());
    EXPECT_TRUE(flushed(log).empty()) << "the next one waits for the next beacon";
}

TEST(OwnLog, ANoteThatAClientWaitsForLeavesAtOnce) {
    OwnLog log = log_of(0);
    log.append(1, note());
    const auto batches = flushed(log, 1);
    ASSERT_EQ(batches.size(), 1U);
    EXPECT_TRUE(batches[0].awaited);
}

TEST(OwnLog, NotesLeaveBeforeThePublishThatFollowsThem) {
    OwnLog log = log_of(0);
    log.append(1, note());
    EXPECT_TRUE(flushed(log).empty());
    log.append(2, test::published(self, 2));
    const auto batches = flushed(log);
    ASSERT_EQ(batches.size(), 1U);
    EXPECT_EQ(batches[0].first_seq, 1U);
    EXPECT_EQ(batches[0].events.size(), 2U);
    EXPECT_TRUE(batches[0].awaited);
}

TEST(OwnLog, NotesThatFillABatchWaitForNothing) {
    OwnLog log = log_of(0);
    for (Seq seq = 1; seq < events_per_batch; ++seq) log.append(seq, note());
    EXPECT_TRUE(flushed(log).empty());
    log.append(events_per_batch, note());
    const auto batches = flushed(log);
    ASSERT_EQ(batches.size(), 1U);
    EXPECT_EQ(batches[0].events.size(), events_per_batch);
    EXPECT_FALSE(batches[0].awaited);
}

TEST(OwnLog, ATailIsSentPieceByPiece) {
    const OwnLog log = log_of(10'000);
    Seq after = 17;
    std::size_t pieces = 0;
    while (after < log.last()) {
        Outbox out;
        ASSERT_TRUE(send_tail(log.history(), {self, log.last()}, after, peer, out));
        ASSERT_EQ(out.size(), 1U);
        EXPECT_EQ(out[0].to, peer);
        const auto& tail = std::get<LogBatch>(out[0].message);
        EXPECT_EQ(tail.first_seq, after + 1);
        ASSERT_FALSE(tail.events.empty());
        EXPECT_LE(tail.events.size(), 256U);
        after += tail.events.size();
        ++pieces;
    }
    EXPECT_GE(pieces, 10'000U / 256);
}

// What only the sender holds, it is not part of the log.
TEST(OwnLog, ATailEndsWhereTheLogEnds) {
    Outbox out;
    EXPECT_TRUE(send_tail(log_of(9).history(), {self, 7}, 5, peer, out));
    ASSERT_EQ(out.size(), 1U);
    EXPECT_EQ(std::get<LogBatch>(out[0].message).events.size(), 2U);
}

TEST(OwnLog, WhoHoldsAllIsSentNothing) {
    Outbox out;
    EXPECT_TRUE(send_tail(log_of(5).history(), {self, 5}, 5, peer, out));
    EXPECT_TRUE(out.empty());
}

TEST(OwnLog, WhoLagsByMoreThanIsKeptNeedsASnapshot) {
    const OwnLog log = log_of(20, 10);
    Outbox out;
    EXPECT_FALSE(send_tail(log.history(), {self, 20}, 9, peer, out));
    EXPECT_FALSE(send_tail(log.history(), {self, 20}, 21, peer, out)) << "more than there is";
    EXPECT_TRUE(send_tail(log.history(), {self, 20}, 10, peer, out));
    EXPECT_EQ(out.size(), 1U);
}

}  // namespace
}  // namespace romano::cluster::own_log_test
