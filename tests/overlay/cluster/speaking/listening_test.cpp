#include "overlay/cluster/speaking/listening.h"

#include <gtest/gtest.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::listening_test {
namespace {

using namespace std::chrono_literals;

const LogId self = test::log_of("self");
const LogId peer = test::log_of("peer");

Beacon beacon(std::uint64_t tick, bool in_view, bool hears_us) {
    Beacon said{.log = peer, .tick = tick};
    said.view.members = {peer};
    if (in_view) said.view.members = {std::min(self, peer), std::max(self, peer)};
    if (hears_us) said.hears = {self.broker};
    return said;
}

class ListeningTest : public testing::Test {
protected:
    ListeningTest() {
        (void)membership.on_beacon(Instant{}, beacon(100, true, true));
        listening.begin(membership, 400ms, 10ms);
    }

    Membership membership{ClusterOptions{}, self.broker, 1};
    Listening listening;
    Instant now{1s};
};

TEST_F(ListeningTest, ABeaconFromTheEndOfTheStallIsUpToDate) {
    listening.on_beacon(now, self, beacon(101, true, true));
    EXPECT_FALSE(listening.is_up_to_date());
    listening.on_beacon(now, self, beacon(135, true, true));
    EXPECT_TRUE(listening.is_up_to_date());
}

// A beacon from the end of the second stall may be from the middle of the first one.
TEST_F(ListeningTest, AfterASecondStallOnTopOfItTheFirstOnesBeaconIsAwaitedStill) {
    listening.begin(membership, 20ms, 10ms);
    listening.on_beacon(now, self, beacon(110, true, true));
    EXPECT_FALSE(listening.is_up_to_date());
    listening.on_beacon(now, self, beacon(135, true, true));
    EXPECT_TRUE(listening.is_up_to_date());
    listening.end();
    listening.begin(membership, 20ms, 10ms);
    listening.on_beacon(now, self, beacon(136, true, true));
    EXPECT_TRUE(listening.is_up_to_date());
}

// It removes us as soon as the others agree: to speak now would be to speak beside our heir
// (simulator, fault `stop`, acks all, seed 471).
TEST_F(ListeningTest, AMemberThatDoesNotHearUsDoubtsUs) {
    listening.on_beacon(now, self, beacon(135, true, false));
    EXPECT_TRUE(listening.is_doubted(now));
    listening.on_beacon(now, self, beacon(136, true, true));
    EXPECT_FALSE(listening.is_doubted(now));
}

// It stands still itself: to wait for it would take longer than the others wait for us (simulator,
// faults `relapse`, seed 9870835).
TEST_F(ListeningTest, AMemberThatHasFallenSilentSinceDoubtsUsNoMore) {
    listening.on_beacon(now, self, beacon(135, true, false));
    now += membership.detection_time() - 10ms;
    EXPECT_TRUE(listening.is_doubted(now));
    listening.on_beacon(now, self, beacon(136, true, false));
    now += membership.detection_time() - 10ms;
    EXPECT_TRUE(listening.is_doubted(now));
    now += 10ms;
    EXPECT_FALSE(listening.is_doubted(now));
}

TEST_F(ListeningTest, AStrangerThatHasNeverHeardUsDoesNot) {
    listening.on_beacon(now, self, beacon(135, false, false));
    EXPECT_FALSE(listening.is_doubted(now));
    EXPECT_TRUE(listening.take_heard());
}

// It cannot know that we were replaced (simulator, faults `stop` and `crash`, seed 161).
TEST_F(ListeningTest, ANewcomerInNoViewTellsNothing) {
    Beacon said = beacon(135, true, true);
    said.view.members.clear();
    listening.on_beacon(now, self, said);
    EXPECT_FALSE(listening.take_heard());
    EXPECT_FALSE(listening.is_up_to_date());
}

}  // namespace
}  // namespace romano::cluster::listening_test
