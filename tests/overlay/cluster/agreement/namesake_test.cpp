#include "overlay/cluster/agreement/namesake.h"

#include <gmock/gmock.h>

#include <chrono>

#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::namesake_test {
namespace {

using namespace std::chrono_literals;
using namespace two_brokers;

constexpr std::uint64_t own_process = 5;

TEST(Namesake, IsToldOfOnceAndThenNotOften) {
    Namesake namesake;
    int told = 0;
    for (Duration at{}; at < 100s; at += 10ms) {
        told += namesake.on_message(Instant{at}, 20s, "self", own_process, 6) ? 1 : 0;
    }
    EXPECT_EQ(told, 5) << "after 0.2 s, and every 20 s from there";
}

TEST(Namesake, LastWordsOfAFormerLifeAreNone) {
    Namesake namesake;
    const auto hears = [&](std::uint64_t process) {
        return namesake.on_message(Instant{}, 20s, "self", own_process, process).has_value();
    };
    for (std::uint64_t life = 1; life < own_process; ++life) {
        for (int i = 0; i < 10; ++i) EXPECT_FALSE(hears(life));
    }
    for (int i = 0; i < 100; ++i) EXPECT_FALSE(hears(own_process));
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
