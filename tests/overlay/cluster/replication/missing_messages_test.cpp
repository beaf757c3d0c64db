// Deliveries of a peer's sessions whose messages were published at a broker that nobody here knew.

#include <gtest/gtest.h>

#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::missing_messages_test {
namespace {

using namespace two_brokers;

const LogPosition unknown{test::log_of("unknown"), 7};

/// The peer is home to a robot for which two messages wait: one of the peer's own, and one that
/// "unknown" published.
struct MissingMessagesTest : testing::Test, Cluster {
    MissingMessagesTest() {
        hear(3);
        take(LogBatch{peer, 1, {test::session("robot", theirs), routed(own), routed(unknown)}});
        hear(3);
        (void)take_sent<SnapshotRequest>();
    }
    static LogEvent routed(const LogPosition& message) {
        return broker::Routed{message, {{"robot", mqttsn::Qos::at_least_once}}};
    }
    [[nodiscard]] std::size_t missing() const {
        return core.peer_logs().at(peer).mirror().unresolved().size();
    }
    std::size_t requests_in(Duration time) {
        std::size_t requests = 0;
        for (const Instant end = now + time; now < end;) {
            hear(3);
            for (const auto& request : take_sent<SnapshotRequest>()) {
                EXPECT_EQ(request.log, peer);
                EXPECT_EQ(request.after, 0U);
                ++requests;
            }
        }
        return requests;
    }
    /// Of the peer's log as it was before what is held here of it.
    static SnapshotPart snapshot() {
        broker::SessionImage robot = image(0, theirs);
        robot.header.client_id = "robot";
        broker::Message message{};
        message.position = unknown;
        message.topic = "pose";
        robot.deliveries.push_back(
            {.position = unknown, .message = MessagePtr{std::move(message)}});
        return {.as_of = {peer, 2}, .last = true, .sessions = {std::move(robot)}};
    }

    const LogPosition own{peer, 1};
};

TEST_F(MissingMessagesTest, P1_WhatIsMissingForLongIsAskedOfItsHome) {
    ASSERT_EQ(missing(), 2U);
    EXPECT_EQ(requests_in(300ms), 0U) << "most comes a moment later";
    EXPECT_EQ(requests_in(300ms), 1U);
}

TEST_F(MissingMessagesTest, P1_AnOldSnapshotBringsThem) {
    take(snapshot());
    EXPECT_EQ(missing(), 1U);
}

TEST_F(MissingMessagesTest, WhatIsDeliveredIsMissedNoMore) {
    take(LogBatch{
        peer, 4, {broker::DeliveryEnded{"robot", own}, broker::DeliveryEnded{"robot", unknown}}});
    EXPECT_EQ(missing(), 0U);
    EXPECT_EQ(requests_in(1s), 0U);
}

}  // namespace
}  // namespace romano::cluster::missing_messages_test
