#include "overlay/cluster/replication/quick_holder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "overlay/cluster/options.h"
#include "tests/overlay/cluster/events.h"

namespace romano::cluster::quick_holder_test {
namespace {

using broker::LogId;

std::vector<LogId> members(std::size_t count) {
    std::vector<LogId> all;
    for (std::size_t i = 0; i < count; ++i) all.push_back(test::log_of("b" + std::to_string(i)));
    return all;
}

/// Who of `all` acknowledges the log of `writer` at once, when each hears all the others.
std::vector<LogId> quick_holders(const std::vector<LogId>& all, const LogId& writer,
                                 std::uint32_t acks) {
    std::vector<LogId> quick;
    for (const LogId& self : all) {
        if (self == writer) continue;
        std::vector<LogId> heard = all;
        std::erase(heard, self);
        if (is_quick_holder(self.broker, writer.broker, heard, acks)) quick.push_back(self);
    }
    return quick;
}

TEST(QuickHolder, OneMoreThanClientsWaitFor) {
    const auto all = members(8);
    for (const LogId& writer : all) {
        EXPECT_EQ(quick_holders(all, writer, 1).size(), 2U);
        EXPECT_EQ(quick_holders(all, writer, 3).size(), 4U);
    }
}

TEST(QuickHolder, AllWhenAllMustHoldIt) {
    const auto all = members(8);
    EXPECT_EQ(quick_holders(all, all[3], all_peers).size(), 7U);
    EXPECT_EQ(quick_holders(all, all[3], 7).size(), 7U);
    EXPECT_EQ(quick_holders(members(3), members(3)[0], 1).size(), 2U);
}

TEST(QuickHolder, WritersShareTheirHoldersOut) {
    const auto all = members(8);
    for (const LogId& member : all) {
        const auto asked = std::ranges::count_if(all, [&](const LogId& writer) {
            return std::ranges::count(quick_holders(all, writer, 1), member) != 0;
        });
        EXPECT_EQ(asked, 2);
    }
}

TEST(QuickHolder, WhoIsNotHeardCountsForNobody) {
    auto all = members(5);
    const LogId writer = all[0];
    const auto before = quick_holders(all, writer, 1);
    ASSERT_EQ(before.size(), 2U);
    std::erase(all, before[0]);
    const auto after = quick_holders(all, writer, 1);
    EXPECT_EQ(after.size(), 2U);
    EXPECT_EQ(std::ranges::count(after, before[1]), 1);
}

}  // namespace
}  // namespace romano::cluster::quick_holder_test
