#include "overlay/cluster/speaking/stall.h"

#include <gmock/gmock.h>

#include <vector>

namespace romano::cluster::stall_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;

constexpr Duration beacon = 10ms;
constexpr Duration detection = 60ms;
const Instant due{1s};

struct StallTest : testing::Test {
    [[nodiscard]] bool is_noticed(Duration late) const {
        return stall.is_noticed(due + late, due, detection);
    }
    /// When it pulses, as milliseconds since it was due, up to then.
    std::vector<std::int64_t> pulses_until(Duration end) {
        std::vector<std::int64_t> sent;
        for (; now < due + end; now += 1ms) {
            if (stall.take_pulse(now)) sent.push_back((now - due) / 1ms);
        }
        return sent;
    }

    Stall stall{beacon};
    Instant now{due + 50ms};
};

TEST_F(StallTest, IsNoticedBeforeAnyPeerReplacesUs) {
    EXPECT_FALSE(is_noticed(34ms));
    EXPECT_TRUE(is_noticed(35ms));
    EXPECT_FALSE(stall.is_noticed(due, Instant::min(), detection)) << "it never was to wake up";
}

TEST_F(StallTest, PulsesAtEachBeaconTimeForADetectionTime) {
    EXPECT_EQ(stall.begin(now, due, detection), 50ms);
    EXPECT_THAT(pulses_until(1s), ElementsAre(50, 60, 70, 80, 90, 100));
}

TEST_F(StallTest, ASecondStallOnTopOfItBringsNoMorePulses) {
    (void)stall.begin(now, due, detection);
    EXPECT_THAT(pulses_until(85ms), ElementsAre(50, 60, 70, 80));
    now = due + 105ms;
    ASSERT_TRUE(stall.is_noticed(now, due, detection)) << "it was to wake up at 80";
    (void)stall.begin(now, due, detection);
    EXPECT_THAT(pulses_until(1s), ElementsAre(105));
}

TEST_F(StallTest, AfterItAStallIsANewOne) {
    (void)stall.begin(now, due, detection);
    stall.end();
    now = due + 500ms;
    (void)stall.begin(now, due + 400ms, detection);
    EXPECT_THAT(pulses_until(1s), ElementsAre(500, 510, 520, 530, 540, 550));
}

TEST_F(StallTest, EndsByPatienceWhenNobodyTellsAnything) {
    cluster::Listening nobody;
    nobody.begin(cluster::Membership{{}, broker::broker_id_of("self"), 1}, 50ms, beacon);
    (void)stall.begin(now, due, detection);  // away for 50 ms: five beats of patience
    for (int beat = 0; beat < 5; ++beat) {
        ASSERT_EQ(stall.listen_until(), now + (beat == 0 ? 3 * beacon : beacon));
        now = stall.listen_until();
        EXPECT_FALSE(stall.is_over(now, nobody, false)) << beat;
    }
    EXPECT_TRUE(stall.is_over(stall.listen_until(), nobody, false));
    EXPECT_TRUE(stall.is_over(now, nobody, true)) << "there is nobody to listen to";
}

// Simulator, a broker whose core hung just after it had been stopped for a second.
TEST_F(StallTest, ASecondStallOnTopOfItEndsNoPatience) {
    (void)stall.begin(due + 1s, due, detection);
    const Instant again = stall.listen_until() + 2 * beacon;
    (void)stall.begin(again, due, detection);
    cluster::Listening nobody;
    nobody.begin(cluster::Membership{{}, broker::broker_id_of("self"), 1}, 20ms, beacon);
    for (int beat = 0; beat < 100; ++beat) {
        EXPECT_FALSE(stall.is_over(stall.listen_until(), nobody, false)) << beat;
    }
    EXPECT_TRUE(stall.is_over(stall.listen_until(), nobody, false));
}

// P3: its patience ended in the moment in which it was replaced, and it said one thing more
// (simulator, faults `relapse`, seed 9978575).
TEST_F(StallTest, P3_WhoIsTakenForDeadCallsForADetectionTimeBeforeItSpeaks) {
    const broker::LogId self{broker::broker_id_of("self"), 1};
    const broker::LogId peer{broker::broker_id_of("peer"), 1};
    cluster::Membership membership{{}, self.broker, 1};
    cluster::Listening doubted;
    cluster::Beacon beacon_of_peer{.log = peer, .tick = 1};
    beacon_of_peer.view.members = {std::min(self, peer), std::max(self, peer)};
    doubted.begin(membership, 50ms, beacon);
    (void)stall.begin(now, due, detection);
    int calls = 0;
    for (int beat = 0; beat < 5 + detection / beacon; ++beat) {
        now = stall.listen_until();
        doubted.on_beacon(now, self, beacon_of_peer);
        ASSERT_FALSE(stall.is_over(now, doubted, false)) << beat;
        EXPECT_EQ(stall.is_calling(), beat >= 5);
        if (stall.is_calling()) ++calls;
    }
    EXPECT_EQ(calls, detection / beacon);
    EXPECT_TRUE(stall.is_over(now, doubted, false)) << "it may never hear us";
    stall.end();
    EXPECT_FALSE(stall.is_calling());
}

}  // namespace
}  // namespace romano::cluster::stall_test
