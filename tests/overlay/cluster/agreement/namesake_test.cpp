#include "overlay/cluster/agreement/namesake.h"

#include <gmock/gmock.h>

#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::namesake_test {
namespace {

using namespace two_brokers;

constexpr std::uint64_t own_process = 5;

TEST(Namesake, IsToldOfOnceAndThenNotOften) {
    Namesake namesake;
    int told = 0;
    for (int i = 0; i < 1'000; ++i) told += namesake.on_message("self", own_process, 6) ? 1 : 0;
    EXPECT_EQ(told, 1);
    for (int i = 0; i < 10'000; ++i) told += namesake.on_message("self", own_process, 6) ? 1 : 0;
    EXPECT_EQ(told, 6);
}

TEST(Namesake, LastWordsOfAFormerLifeAreNone) {
    Namesake namesake;
    for (std::uint64_t life = 1; life < own_process; ++life) {
        for (int i = 0; i < 10; ++i) EXPECT_FALSE(namesake.on_message("self", own_process, life));
    }
    for (int i = 0; i < 100; ++i)
        EXPECT_FALSE(namesake.on_message("self", own_process, own_process));
}

TEST(Namesake, AClusterCoreWarnsOfIt) {
    Cluster cluster;
    for (int i = 0; i < 50; ++i) {
        Effects acting = cluster.effects();
        const LogId other{self.broker, self.incarnation + 1};
        cluster.core.on_message(acting, {other, Heartbeat{.log = other}});
    }
    ASSERT_EQ(cluster.local.size(), 1U);
    const auto& notice = std::get<Notice>(cluster.local.front());
    EXPECT_TRUE(notice.is_warning);
    EXPECT_THAT(notice.text, testing::HasSubstr("named self"));
}

}  // namespace
}  // namespace romano::cluster::namesake_test
