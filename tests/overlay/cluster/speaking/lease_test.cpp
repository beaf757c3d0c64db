#include "overlay/cluster/speaking/lease.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <set>
#include <vector>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::lease_test {
namespace {

using namespace std::chrono_literals;
using testing::IsEmpty;

const LogId self = test::log_of("self");
const LogId a = test::log_of("a");
const LogId b = test::log_of("b");
const LogId c = test::log_of("c");
const LogId d = test::log_of("d");

constexpr Duration beacon = 10ms;
constexpr Duration term = 50ms;  // the detection timeout
constexpr Duration margin = 10ms;

ViewNumber number(std::uint64_t count) {
    return {.term = 1, .leader = self.broker, .count = count};
}
View view(std::uint64_t count, std::vector<LogId> members) {
    std::ranges::sort(members);
    return {.number = number(count), .members = std::move(members)};
}

struct LeaseTest : testing::Test {
    /// A heartbeat, echoed at once by those.
    void beat(const std::vector<LogId>& by, std::uint64_t installed = 1) {
        lease.on_beat(now, ++tick);
        for (const LogId& peer : by) lease.on_echo(peer, tick, number(installed), {});
    }
    [[nodiscard]] bool is_held_after(Duration time) const { return lease.is_held(now + time); }
    void hear(const std::vector<LogId>& peers) {
        for (const LogId& peer : peers) lease.on_heard(now, peer, ++heard);
    }
    /// How long it waits before it promises that.
    [[nodiscard]] Duration waits_for(const View& next) const {
        const Instant over =
            lease.is_over_at(next, [this](const LogId& log) { return ended.contains(log); });
        return std::max(over, now) - now;
    }
    [[nodiscard]] bool echoes(const LogId& peer) const {
        return std::ranges::count(lease.echoes(), peer, &Echo::of) > 0;
    }

    Lease lease{self, beacon, term};
    Instant now{10s};
    std::uint64_t tick = 100;
    std::uint64_t heard = 0;
    std::set<LogId> ended;
};

TEST_F(LeaseTest, NobodyHoldsOneInNoView) {
    beat({a, b});
    EXPECT_FALSE(is_held_after(0ms));
}

TEST_F(LeaseTest, AViewTellsWhetherThereWasOneUntilThen) {
    lease.on_view(now, view(1, {self, a, b}));
    EXPECT_FALSE(lease.was_held_before());
    beat({a, b});
    lease.on_view(now, view(2, {self, a, b}));
    EXPECT_TRUE(lease.was_held_before());
    now += 1s;
    lease.on_view(now, view(3, {self, a, b}));
    EXPECT_FALSE(lease.was_held_before());
}

TEST_F(LeaseTest, WhoIsAloneInItsViewHoldsOne) {
    lease.on_view(now, view(1, {self}));
    EXPECT_TRUE(is_held_after(1h));
}

TEST_F(LeaseTest, MoreThanHalfOfTheViewVouchForATerm) {
    lease.on_view(now, view(1, {self, a, b, c}));
    beat({a, b, c});
    EXPECT_TRUE(is_held_after(term - margin - 1ms));
    EXPECT_FALSE(is_held_after(term - margin));
    now += 20ms;
    beat({a});
    EXPECT_FALSE(is_held_after(term - margin - 20ms)) << "two of four are no majority";
    beat({a, b});
    EXPECT_TRUE(is_held_after(term - margin - 1ms));
}

TEST_F(LeaseTest, AMemberThatVouchedWithinThreeTermsEndsNoLease) {
    lease.on_view(now, view(1, {self, a, b}));
    beat({a, b});
    for (now += beacon; now < Instant{10s} + 3 * (term - margin); now += beacon) {
        EXPECT_TRUE(is_held_after(0ms));
        beat({a});
    }
    now = Instant{10s} + 3 * (term - margin);
    EXPECT_FALSE(is_held_after(0ms));
}

TEST_F(LeaseTest, OfTwoMembersBothVouchWithinATerm) {
    lease.on_view(now, view(1, {self, a}));
    beat({a});
    EXPECT_TRUE(is_held_after(term - margin - 1ms));
    EXPECT_FALSE(is_held_after(term - margin));
}

TEST_F(LeaseTest, AMemberThatNeverVouchedIsWaitedFor) {
    lease.on_view(now, view(1, {self, a, b}));
    beat({a});
    EXPECT_FALSE(is_held_after(0ms));
    beat({b});
    EXPECT_TRUE(is_held_after(0ms));
}

TEST_F(LeaseTest, AThirdMemberVouchesForOneThatIsNotHeardForATermLess) {
    lease.on_view(now, view(1, {self, a, b}));
    const auto beat_and_hear = [&](const std::vector<BrokerId>& vouched) {
        now += beacon;
        lease.on_beat(now, ++tick);
        lease.on_echo(a, tick, number(1), vouched);
    };
    beat_and_hear({self.broker, b.broker});
    EXPECT_FALSE(is_held_after(0ms)) << "what b serves is not known yet";
    beat({b});
    for (int i = 0; i < 50; ++i) beat_and_hear({self.broker, b.broker});
    EXPECT_TRUE(is_held_after(0ms));
    for (int i = 0; i < 10; ++i) beat_and_hear({self.broker});
    EXPECT_FALSE(is_held_after(0ms)) << "b said nothing to a either";
}

TEST_F(LeaseTest, AMemberThatIsNeverHeardIsVouchedForAfterTenTerms) {
    lease.on_view(now, view(1, {self, a, b}));
    const Instant met = now + 10 * term;
    for (; now <= met; now += beacon) {
        EXPECT_FALSE(is_held_after(0ms)) << (now - Instant{10s}) / 1ms << " ms";
        lease.on_beat(now, ++tick);
        lease.on_echo(a, tick, number(1), {self.broker, b.broker});
    }
    EXPECT_TRUE(is_held_after(0ms));
}

TEST_F(LeaseTest, WhoEchoedATickWithinATermVouches) {
    lease.on_view(now, view(1, {self, a, b}));
    beat({a});
    EXPECT_THAT(lease.vouched(now + term - margin - 1ms), testing::ElementsAre(a.broker));
    EXPECT_THAT(lease.vouched(now + term - margin), IsEmpty());
}

TEST_F(LeaseTest, AnEchoInALaterViewCountsWhenThatIsInstalled) {
    lease.on_view(now, view(1, {self, a}));
    beat({a}, 2);
    EXPECT_FALSE(is_held_after(0ms));
    lease.on_view(now, view(2, {self, a}));
    EXPECT_TRUE(is_held_after(0ms));
}

// Three machines whose time daemons slew their clocks as far as they may (I1): the one that speaks
// takes its time to be shorter than it is, and the one that waits takes its own to be longer.
struct SlewedClocks : testing::Test {
    static Instant slow(Duration time) { return Instant{10s} + time * 11 / 12; }
    static Instant fast(Duration time) { return Instant{10s} + time * 13 / 12; }

    SlewedClocks() {
        for (Lease* each : {&speaks, &waits, &vouches}) {
            each->on_view(Instant{10s}, view(1, {self, a, b}));
        }
        hear_speaker(0ms, {a, b}, {});
    }
    /// Its next heartbeat is echoed by those.
    void hear_speaker(Duration time, const std::vector<LogId>& by,
                      const std::vector<BrokerId>& vouched) {
        speaks.on_beat(slow(time), ++tick);
        for (const LogId& peer : by) speaks.on_echo(peer, tick, number(1), vouched);
        if (std::ranges::count(by, a) > 0) waits.on_heard(fast(time), self, tick);
    }
    [[nodiscard]] bool may_promise(Duration time, const View& next) const {
        const auto has_ended = [](const LogId&) { return false; };
        return fast(time) >= waits.is_over_at(next, has_ended);
    }
    /// By then what still waited for a socket has left, too.
    [[nodiscard]] bool spoke_just_now(Duration time) const {
        return speaks.is_held(slow(time - 1ms));
    }

    Lease speaks{self, beacon, 50ms};
    Lease waits{a, beacon, 50ms};
    Lease vouches{b, beacon, 50ms};
    std::uint64_t tick = 100;
};

TEST_F(SlewedClocks, WhoIsLeftOutByMostIsSilentBeforeTheyGoOn) {
    Duration time = 0ms;
    for (; !may_promise(time, view(2, {a, b})); time += 100us) {
    }
    EXPECT_FALSE(spoke_just_now(time)) << time / 1us << " us";
}

TEST_F(SlewedClocks, WhoIsLeftOutByOneIsSilentBeforeThatOneGoesOn) {
    Duration time = 0ms;
    for (; !may_promise(time, view(2, {a})); time += 100us) {
        if (time % beacon == 0ms) hear_speaker(time, {b}, {});
    }
    EXPECT_FALSE(spoke_just_now(time)) << time / 1us << " us";
}

// Two members more echo at all times, so that it is not the majority that ends the lease.
TEST_F(SlewedClocks, WhoIsVouchedForIsSilentBeforeThatOneGoesOn) {
    for (Lease* each : {&speaks, &waits, &vouches}) {
        each->on_view(Instant{10s}, view(1, {self, a, b, c, d}));
    }
    hear_speaker(0ms, {a, b, c, d}, {});
    vouches.on_beat(slow(0ms), 1);
    vouches.on_echo(a, 1, number(1), {});
    waits.on_heard(fast(0ms), b, 1);
    Duration time = 0ms;
    for (; !may_promise(time, view(2, {a})); time += 100us) {
        if (time % 1ms != 0ms) continue;
        hear_speaker(time, {c, d}, {});
        const auto vouched = vouches.vouched(slow(time));
        if (!vouched.empty()) speaks.on_echo(b, tick, number(1), vouched);
    }
    EXPECT_FALSE(spoke_just_now(time)) << time / 1us << " us";
}

TEST_F(LeaseTest, EchoesOfTicksFromBeforeAStandstillAreTooOld) {
    lease.on_view(now, view(1, {self, a}));
    beat({a});
    const std::uint64_t before = tick;
    now += 1s;
    beat({});
    lease.on_echo(a, before, number(1), {});
    EXPECT_FALSE(is_held_after(0ms));
    lease.on_echo(a, tick, number(1), {});
    EXPECT_TRUE(is_held_after(0ms));
}

TEST_F(LeaseTest, FromAPromiseOnItsMajorityVouchesToo) {
    lease.on_view(now, view(1, {self, a, b}));
    beat({a, b});
    lease.on_promise(view(2, {self, b, c, d}));
    EXPECT_FALSE(is_held_after(0ms)) << "c and d vouch for nobody in that view yet";
}

TEST_F(LeaseTest, WhoIsLeftOutIsWaitedForATermSinceItsLastEchoedTick) {
    lease.on_view(now, view(1, {self, a, b}));
    hear({a, b});
    now += 15ms;
    EXPECT_EQ(waits_for(view(2, {self, a})), term - 15ms);
    hear({b});
    EXPECT_EQ(waits_for(view(2, {self, a})), term);
    EXPECT_EQ(waits_for(view(2, {self, a, b})), 0ms);
}

TEST_F(LeaseTest, AViewWithLessThanHalfWaitsForThreeTerms) {
    lease.on_view(now, view(1, {self, a, b}));
    hear({a, b});
    EXPECT_EQ(waits_for(view(2, {self})), 3 * term);
    lease.on_view(now, view(2, {self, a}));
    EXPECT_EQ(waits_for(view(3, {self})), term) << "of two, each goes on at once";
    lease.on_promise(view(3, {self, a, b}));
    EXPECT_EQ(waits_for(view(4, {self})), 3 * term) << "of one that was promised, too";
}

TEST_F(LeaseTest, WhoEndedForCertainIsNotWaitedFor) {
    lease.on_view(now, view(1, {self, a, b}));
    hear({a, b});
    ended.insert(b);
    EXPECT_EQ(waits_for(view(2, {self, a})), 0ms);
}

TEST_F(LeaseTest, WhoIsToBeLeftOutIsNotEchoedThoughItIsHeard) {
    lease.on_view(now, view(1, {self, a, b}));
    hear({a, b});
    ASSERT_TRUE(echoes(b));
    const View without = view(2, {self, a});
    lease.want(&without);
    EXPECT_FALSE(echoes(b));
    EXPECT_TRUE(echoes(a));
    now += 20ms;
    hear({b});
    EXPECT_EQ(waits_for(without), term - 20ms) << "what is not echoed prolongs nothing";
    lease.want(nullptr);
    EXPECT_TRUE(echoes(b));
}

TEST_F(LeaseTest, WhoIsLeftOutByAPromiseIsEchoedAgainInAViewWithIt) {
    lease.on_view(now, view(1, {self, a, b}));
    hear({a, b});
    lease.on_promise(view(2, {self, a}));
    lease.want(nullptr);
    EXPECT_FALSE(echoes(b));
    lease.on_promise(view(3, {self, a, b}));
    EXPECT_FALSE(echoes(b)) << "promised, and not installed";
    lease.on_view(now, view(3, {self, a, b}));
    EXPECT_TRUE(echoes(b));
}

TEST_F(LeaseTest, OnlyMembersAreEchoed) {
    hear({a, b});
    EXPECT_THAT(lease.echoes(), IsEmpty());
    lease.on_view(now, view(1, {self, a}));
    EXPECT_TRUE(echoes(a));
    EXPECT_FALSE(echoes(b));
}

TEST_F(LeaseTest, AfterAStandstillThoseNotHeardSinceAreWaitedForAsLongAsItWasAway) {
    lease.on_view(now, view(1, {self, a, b}));
    beat({a, b});
    hear({a, b});
    now += 400ms;
    beat({});
    ended.insert(b);
    EXPECT_EQ(waits_for(view(2, {self, a})), 400ms);
    lease.on_heard(now, b, heard + 10);
    EXPECT_EQ(waits_for(view(2, {self, a})), 400ms) << "sent before the standstill was over";
    lease.on_heard(now, b, heard + 30);
    EXPECT_EQ(waits_for(view(2, {self, a})), 0ms);
}

}  // namespace
}  // namespace romano::cluster::lease_test
