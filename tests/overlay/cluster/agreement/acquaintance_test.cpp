#include "overlay/cluster/agreement/acquaintance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::acquaintance_test {
namespace {

using namespace std::chrono_literals;

const LogId self = test::log_of("self");
const LogId one = test::log_of("one");
const LogId other = test::log_of("other");

struct AcquaintanceTest : testing::Test {
    AcquaintanceTest() {
        for (const LogId& log : {one, other}) logs.try_emplace(log, log, 100);
    }
    void see(std::vector<LogId> members, bool had_lease = true) {
        std::ranges::sort(members);
        acquaintance.on_view(now, test::times, self,
                             View{.number = {}, .members = std::move(members)}, had_lease, logs);
    }
    void carry_on() {
        acquaintance.carry_on(now, logs,
                              [this](const LogId& member) { return known.contains(member); });
    }

    /// Its writer says how far it has written; then so much of it is read.
    void hear(const LogId& log, Seq end) { acquaintance.meet(log, end); }
    void read(const LogId& log, Seq through) {
        PeerLog& held = logs.at(log);
        for (Seq seq = held.applied() + 1; seq <= through; ++seq) {
            held.offer(seq, {test::session("robot")});
            held.apply();
        }
        carry_on();
    }

    Instant now{1s};
    PeerLogs logs;
    std::set<LogId> known;
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
    acquaintance = {};
    see({self, one});
    EXPECT_FALSE(logs.at(one).was_apart());
}

TEST_F(AcquaintanceTest, ANewcomerMeetsThoseWhoTookItIn) {
    logs.erase(other);
    see({self, one, other});
    EXPECT_FALSE(acquaintance.has_met_all());
    acquaintance.meet(other, 0);
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

// A robot came there that was at home at a member: it was told that it is a stranger.
TEST_F(AcquaintanceTest, P1_StrangersMayRoamUntilANewcomerHasReadWhatMembersHadWritten) {
    see({self, one, other});
    EXPECT_TRUE(acquaintance.may_roam()) << "nobody has said how much there is";
    hear(one, 2);
    hear(other, 0);
    read(one, 1);
    EXPECT_TRUE(acquaintance.may_roam());
    hear(one, 5);  // it goes on
    read(one, 2);
    EXPECT_FALSE(acquaintance.may_roam());
    see({self, one, other, test::log_of("later")});
    EXPECT_FALSE(acquaintance.may_roam()) << "only those of its first view";
}

// Seed 19192, as shipped: a newcomer held the events of a sleeper's home, and of the publisher's
// log a snapshot without what the others had worked through. The sleeper came there before its home
// was asked for that.
TEST_F(AcquaintanceTest, I6_ALogIsReadWhenTheMessagesThatItNamesAreHere) {
    const broker::LogEvent message = test::published(other, 7);
    const broker::Routed routed{{other, 7}, {{"robot", mqttsn::Qos::exactly_once}}};
    see({self, one});
    logs.at(one).offer(1, {test::session("robot"), routed});
    while (logs.at(one).has_next()) logs.at(one).apply();
    hear(one, 2);
    carry_on();
    EXPECT_TRUE(acquaintance.may_roam());
    logs.at(one).mirror().resolve(std::get<broker::Published>(message).message);
    carry_on();
    EXPECT_FALSE(acquaintance.may_roam());
}

TEST_F(AcquaintanceTest, WhatTheRemovedHadWrittenIsNotWaitedFor) {
    see({self, one});
    hear(one, 7);
    see({self});
    EXPECT_FALSE(acquaintance.may_roam());
}

TEST_F(AcquaintanceTest, StrangersAreAnsweredAfterTwoSecondsAtLast) {
    see({self, one});
    hear(one, 7);
    now += 1999ms;
    carry_on();
    EXPECT_TRUE(acquaintance.may_roam());
    now += 1ms;
    carry_on();
    EXPECT_FALSE(acquaintance.may_roam());
}

// Seeds 3109 and 4537, as shipped: a broker without a majority was taken in again before it had
// heard who served its address meanwhile.
TEST_F(AcquaintanceTest, I1_WhoHadNoLeaseIsReturningUntilItKnowsWhatAllMembersSay) {
    see({self, one, other});
    EXPECT_FALSE(acquaintance.is_returning(now)) << "a newcomer is nowhere at home";
    see({self, one, other}, false);
    known = {one};
    carry_on();
    EXPECT_TRUE(acquaintance.is_returning(now));
    known = {one, other};
    carry_on();
    EXPECT_FALSE(acquaintance.is_returning(now));
}

TEST_F(AcquaintanceTest, WhoHadItsLeaseAllTheTimeWasNotReplaced) {
    see({self, one, other});
    see({self, one});
    EXPECT_FALSE(acquaintance.is_returning(now));
}

// The lease of whoever spoke in its place is over by then.
TEST_F(AcquaintanceTest, WhoHearsAMemberNeverReturnsAfterADetectionTime) {
    see({self, one, other});
    see({self, one, other}, false);
    now += test::times.detection - 1ms;
    carry_on();
    EXPECT_TRUE(acquaintance.is_returning(now));
    now += 1ms;
    EXPECT_FALSE(acquaintance.is_returning(now));
}

TEST_F(AcquaintanceTest, WhoeverIsRemovedMeanwhileSpeaksInNobodysPlace) {
    see({self, one, other});
    see({self, one, other}, false);
    known = {one};
    carry_on();
    see({self, one});
    EXPECT_FALSE(acquaintance.is_returning(now));
}

}  // namespace
}  // namespace romano::cluster::acquaintance_test
