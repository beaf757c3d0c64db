#include "overlay/cluster/snapshot.h"

#include <gmock/gmock.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster {
namespace {

// P3: or an heir would work once more through what was published by a broker that died long ago.
TEST(Snapshot, TellsHowFarTheLogsOfRemovedBrokersWereWorkedThrough) {
    const LogId self = test::log_of("self");
    const LogPosition removed{test::log_of("removed"), 7};
    broker::BrokerOptions options;
    options.log = self;
    options.writes_log = true;
    broker::BrokerCore core(options, 1);
    core.advance_cursor(removed);
    PeerLogs nobody;
    OwnLog own(self, 100);
    Outbox out;
    send_snapshot(core, {nobody, own}, test::log_of("peer").broker, out);
    ASSERT_EQ(out.size(), 1U);
    EXPECT_THAT(std::get<SnapshotPart>(out[0].message).cursors, testing::ElementsAre(removed));
}

}  // namespace
}  // namespace romano::cluster
