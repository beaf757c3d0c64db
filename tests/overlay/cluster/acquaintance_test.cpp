#include "overlay/cluster/acquaintance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster {
namespace {

const LogId self = test::log_of("self");
const LogId one = test::log_of("one");
const LogId other = test::log_of("other");

struct AcquaintanceTest : testing::Test {
    AcquaintanceTest() {
        for (const LogId& log : {one, other}) logs.try_emplace(log, log, 100);
    }
    void see(std::vector<LogId> members) {
        std::ranges::sort(members);
        acquaintance.on_view(self, View{.number = {}, .members = std::move(members)}, logs);
    }

    PeerLogs logs;
    Acquaintance acquaintance;
};

TEST_F(AcquaintanceTest, NobodyWasPartedFromANewcomer) {
    see({self, one, other});
    EXPECT_FALSE(logs.at(one).was_apart());
    EXPECT_FALSE(logs.at(other).was_apart());
}

TEST_F(AcquaintanceTest, WhoComesIntoAViewThatWeHadWithoutItWasParted) {
    see({self, one});
    see({self, one, other});
    EXPECT_FALSE(logs.at(one).was_apart());
    EXPECT_TRUE(logs.at(other).was_apart());
    see({self, one, other});
    EXPECT_FALSE(logs.at(other).was_apart());
}

TEST_F(AcquaintanceTest, WhoBeginsAnewIsANewcomer) {
    see({self});
    acquaintance.restart();
    see({self, one});
    EXPECT_FALSE(logs.at(one).was_apart());
}

TEST_F(AcquaintanceTest, ANewcomerMeetsThoseWhoTookItIn) {
    logs.erase(other);
    see({self, one, other});
    EXPECT_FALSE(acquaintance.has_met_all());
    acquaintance.meet(other);
    EXPECT_TRUE(acquaintance.has_met_all());
    see({self, one, other, test::log_of("later")});
    EXPECT_TRUE(acquaintance.has_met_all()) << "only those of its first view";
}

TEST_F(AcquaintanceTest, WhoWasRemovedNeedNotBeMet) {
    logs.erase(other);
    see({self, one, other});
    see({self, one});
    EXPECT_TRUE(acquaintance.has_met_all());
}

}  // namespace
}  // namespace romano::cluster
