#include "experiments/measure/failover.h"

#include <gtest/gtest.h>

namespace romano::experiments::failover_test {
namespace {

const std::vector<RobotNumber> group = {0, 1, 2};
const std::vector<RobotNumber> victims = {1, 2};

TEST(Failover, IsFromTheFaultToTheFirstArrivalAtEachVictim) {
    DeliveryAccount account;
    const auto first = account.on_published(0, Stream::group, 1, 4.01, group);
    const auto second = account.on_published(0, Stream::group, 1, 4.05, group);
    account.on_arrived(0, first, 0, 4.02);
    account.on_arrived(0, second, 1, 4.20);
    account.on_arrived(0, first, 1, 4.21);
    account.on_arrived(0, first, 2, 4.30);
    const auto failovers = client_failovers(account, victims, 4.0);
    ASSERT_EQ(failovers.size(), 2u);
    EXPECT_EQ(failovers[0].client, 1u);
    EXPECT_NEAR(failovers[0].after_ms.value(), 200, 1e-6);
    EXPECT_NEAR(failovers[1].after_ms.value(), 300, 1e-6);
}

TEST(Failover, IgnoresMessagesPublishedBeforeTheFault) {
    DeliveryAccount account;
    const auto before = account.on_published(0, Stream::group, 1, 3.999, group);
    account.on_arrived(0, before, 1, 4.001);  // lay in the socket's buffer
    account.on_published(0, Stream::group, 1, 4.5, group);
    EXPECT_EQ(client_failovers(account, victims, 4.0)[0].after_ms, std::nullopt);
}

TEST(Failover, OfAVictimThatHearsNothingIsEmpty) {
    DeliveryAccount account;
    account.on_published(0, Stream::group, 1, 4.5, group);
    EXPECT_EQ(client_failovers(account, victims, 4.0)[1].after_ms, std::nullopt);
}

// A broker that is struck just before the load ends has clients that were due nothing more.
TEST(Failover, LeavesOutAVictimToWhichNothingWasPublished) {
    DeliveryAccount account;
    account.on_published(0, Stream::group, 1, 3.9, group);
    const std::vector<RobotNumber> one = {2};
    account.on_published(0, Stream::one_to_one, 1, 4.5, one);
    const auto failovers = client_failovers(account, victims, 4.0);
    ASSERT_EQ(failovers.size(), 1u);
    EXPECT_EQ(failovers[0].client, 2u);
}

}  // namespace
}  // namespace romano::experiments::failover_test
