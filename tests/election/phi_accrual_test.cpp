// The phi accrual detector's rules (Hayashibara et al. 2004) and the rule of the observer's own
// clock.
#include "election/phi_accrual.h"

#include <gtest/gtest.h>

#include <chrono>

#include "romano/base/random.h"

namespace romano::election::phi_accrual_test {
namespace {

using namespace std::chrono_literals;

constexpr NodeId peer{7};
constexpr DetectorOptions options{.beacon_every = 10ms, .timeout = 100ms, .phi_threshold = 8.0};

class PhiAccrual : public testing::Test {
protected:
    /// Beacons with up to `jitter` of delay, and the observer's ticks, for so many intervals.
    void hear(int beacons, Duration jitter) {
        for (int i = 0; i < beacons; ++i) {
            now_ += 10ms;
            detector_.on_tick(now_);
            detector_.on_beacon(now_ + random_.between(Duration{0}, jitter + 1ns), peer);
        }
    }
    /// Silence until suspicion, at most `limit`.
    Duration silence_until_suspected(Duration limit) {
        const Instant begin = now_;
        while (detector_.is_alive(peer) && now_ - begin < limit) {
            now_ += 10ms;
            detector_.on_tick(now_);
        }
        return now_ - begin;
    }

    Random random_{1};
    Instant now_{};
    PhiAccrualDetector detector_{options};
};

TEST_F(PhiAccrual, AnUnknownNodeIsNotAlive) {
    EXPECT_FALSE(detector_.is_alive(peer));
}

TEST_F(PhiAccrual, SuspicionGrowsWithSilence) {
    hear(100, 0ms);
    double last = detector_.phi(peer);
    for (int i = 0; i < 3; ++i) {
        now_ += 10ms;
        detector_.on_tick(now_);
        EXPECT_GT(detector_.phi(peer), last);
        last = detector_.phi(peer);
    }
}

TEST_F(PhiAccrual, RegularBeaconsGiveAQuickDetectionAndJitterASlowerOne) {
    hear(200, 0ms);
    const Duration quick = silence_until_suspected(1s);
    EXPECT_GE(quick, 30ms);
    EXPECT_LE(quick, 60ms);
    EXPECT_EQ(detector_.take_suspects(), std::vector<NodeId>{peer});
    EXPECT_TRUE(detector_.take_suspects().empty()) << "told once";

    detector_.on_beacon(now_, peer);
    hear(200, 30ms);
    const Duration patient = silence_until_suspected(1s);
    EXPECT_GT(patient, quick);
}

TEST_F(PhiAccrual, WithFewBeaconsTheFixedTimeoutDecides) {
    hear(3, 0ms);
    EXPECT_EQ(silence_until_suspected(1s), 100ms);
}

TEST_F(PhiAccrual, TheObserversOwnStallIsNotBlamedOnThePeer) {
    hear(200, 1ms);
    now_ += 5s;
    detector_.on_tick(now_);
    EXPECT_TRUE(detector_.is_alive(peer)) << "one late tick is one tick";
    hear(1, 0ms);
    EXPECT_TRUE(detector_.is_alive(peer));
    EXPECT_LE(silence_until_suspected(1s), 70ms)
        << "the stall is not remembered as the peer's habit";
}

TEST_F(PhiAccrual, ABeaconRevives) {
    hear(100, 0ms);
    (void)silence_until_suspected(1s);
    ASSERT_FALSE(detector_.is_alive(peer));
    detector_.on_beacon(now_, peer);
    EXPECT_TRUE(detector_.is_alive(peer));
}

TEST_F(PhiAccrual, ANodeThatSaidGoodbyeIsSuspectedAtOnce) {
    hear(100, 0ms);
    detector_.on_gone(now_, peer);
    EXPECT_FALSE(detector_.is_alive(peer));
    EXPECT_EQ(detector_.take_suspects().size(), 1U);
    detector_.on_gone(now_, peer);
    EXPECT_TRUE(detector_.take_suspects().empty());
}

TEST_F(PhiAccrual, SilencesThatWereJustNotLongEnoughDoNotPutADetectionOffForever) {
    hear(20, 0ms);
    for (int late = 0; late < 100; ++late) {
        for (Duration silence = 20ms; silence < detector_.detection_time(); silence += 10ms) {
            now_ += 10ms;
            detector_.on_tick(now_);
        }
        ASSERT_TRUE(detector_.is_alive(peer));
        detector_.on_beacon(now_, peer);
    }
    EXPECT_EQ(detector_.detection_time(), 300ms) << "three fixed time-outs";
    EXPECT_LE(silence_until_suspected(10s), 300ms);
}

TEST_F(PhiAccrual, TellsItsDetectionTime) {
    EXPECT_EQ(detector_.detection_time(), 100ms) << "before it knows anybody";
    hear(200, 0ms);
    const Duration told = detector_.detection_time();
    const Duration seen = silence_until_suspected(1s);
    EXPECT_GE(seen, told);
    EXPECT_LT(seen, told + 10ms);
}

}  // namespace
}  // namespace romano::election::phi_accrual_test
