#include "overlay/cluster/replication/snapshot.h"

#include <gmock/gmock.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::snapshot_test {
namespace {

const LogId self = test::log_of("self");

struct SnapshotTest : testing::Test {
    broker::BrokerCore core{test::writer_of(self), 1};
    PeerLogs peers;
    OwnLog own{self, 1'000};
    Logs logs{peers, own};

    void publish(Seq count) {
        for (Seq i = 0; i < count; ++i) {
            own.append(own.last() + 1, test::published(self, own.last() + 1));
        }
    }
};

// P3: or an heir would work once more through what was published by a broker that died long ago.
TEST_F(SnapshotTest, TellsHowFarTheLogsOfRemovedBrokersWereWorkedThrough) {
    const LogPosition removed{test::log_of("removed"), 7};
    core.advance_cursor(removed);
    const SnapshotPart only = Snapshot(core, logs).next(logs);
    EXPECT_TRUE(only.last);
    EXPECT_THAT(only.cursors, testing::ElementsAre(removed));
}

TEST_F(SnapshotTest, HasThePublishesUpToItsEventInOrder) {
    publish(200);
    Snapshot snapshot(core, logs);
    Seq seen = 0;
    for (std::uint32_t number = 0;; ++number) {
        publish(10);  // while it is on its way: of a later event than the snapshot's
        const SnapshotPart part = snapshot.next(logs);
        EXPECT_EQ(part.as_of, (LogPosition{self, 200}));
        EXPECT_EQ(part.part, number);
        EXPECT_LE(part.publishes.size(), 64U);
        for (const auto& message : part.publishes) EXPECT_EQ(message->position.seq, ++seen);
        if (part.last) break;
    }
    EXPECT_EQ(seen, 200U);
}

TEST_F(SnapshotTest, LastWordsAreThePublishesThatTheOtherLacks) {
    const LogId dead = test::log_of("dead");
    PeerLog& log = peers.try_emplace(dead, dead, 1'000).first->second;
    for (Seq seq = 1; seq <= 3; ++seq) {
        log.offer(seq, {test::published(dead, seq)});
        log.apply();
    }
    const SnapshotPart only = Snapshot(*peers.begin(), 1).next(logs);
    EXPECT_TRUE(only.last);
    EXPECT_EQ(only.as_of, (LogPosition{dead, 3}));
    ASSERT_EQ(only.publishes.size(), 2U);
    EXPECT_EQ(only.publishes[0]->position.seq, 2U);
}

}  // namespace
}  // namespace romano::cluster::snapshot_test
