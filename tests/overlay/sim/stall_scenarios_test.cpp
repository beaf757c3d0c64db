// Brokers that stand still for a while (SIGSTOP, SIGCONT, a starved machine), by script. The times
// for repeating are those of the specification, so that nothing is mended by luck in time.

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/overlay/sim/cluster_scenario.h"

namespace romano::sim::stall_scenarios_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

ClusterWorldOptions with_patient_brokers() {
    ClusterWorldOptions options;
    options.t_retry = 10s;
    return options;
}

class StallScenario : public ClusterScenario {
protected:
    StallScenario() : ClusterScenario(with_patient_brokers()) {}

    void begin_under_load() {
        add_one_each({Qos::at_least_once, Qos::exactly_once});
        begin();
        publish(true);
        world.run_for(1s);
    }
    /// The longest way of a message that was asked for since, to whomever.
    [[nodiscard]] Duration longest_delay(Instant since) const {
        Duration longest{0};
        for (const Reception& reception : world.ledger().receptions) {
            const Sent& sent = world.ledger().sent.at({reception.publisher, reception.number});
            if (sent.at >= since) longest = std::max(longest, reception.at - sent.at);
        }
        return longest;
    }
    [[nodiscard]] std::ptrdiff_t acknowledged(const std::string& publisher, Instant since) const {
        return std::ranges::count_if(world.ledger().sent, [&](const auto& entry) {
            const Sent& sent = entry.second;
            return sent.publisher == publisher && sent.at >= since && sent.acknowledged;
        });
    }
};

// The third one waits for them, and they for what it does: a pulse says enough.
TEST_F(StallScenario, TwoOfThreeThatStandStillForTwoDetectionTimesAreNotReplaced) {
    begin_under_load();
    world.broker(0).stop();
    world.broker(1).stop();
    world.run_for(world.options().cluster.detection_timeout * 2);
    world.broker(0).go_on();
    world.broker(1).go_on();
    world.run_for(1s);
    EXPECT_EQ(world.broker(2).member().facts().take_overs, 0U);
    for (const std::size_t late : {0U, 1U}) {
        EXPECT_EQ(world.broker(late).member().facts().replacements, 0U) << late;
    }
    expect_all_promises_kept();
    expect_nobody_noticed();
}

TEST_F(StallScenario, AnAddressIsHandedBackWithoutAPauseInItsQueues) {
    begin_under_load();
    world.broker(1).stop();
    world.run_for(2s);
    const Instant resumed = world.now();
    world.broker(1).go_on();
    world.run_for(3s);
    expect_all_promises_kept();
    expect_nobody_noticed();
    EXPECT_LT(longest_delay(resumed - 500ms), 1s);
}

// Its core waits for a processor, or works: its robots wait for it, and nobody else does anything,
// though it is silent for longer than a detection time until it has listened.
TEST_F(StallScenario, ABrokerThatIsLateByNearlyADetectionTimeIsNotReplaced) {
    begin_under_load();
    world.broker(1).stop_core();
    world.run_for(world.options().cluster.detection_timeout * 9 / 10);
    world.broker(1).go_on();
    world.run_for(1s);
    for (const std::size_t other : {0U, 2U}) {
        EXPECT_EQ(world.broker(other).member().facts().take_overs, 0U) << other;
    }
    EXPECT_EQ(world.broker(1).member().facts().replacements, 0U);
    expect_all_promises_kept();
    expect_nobody_noticed();
}

TEST_F(StallScenario, ABrokerWhoseCoreHangsIsReplacedAfterOneAndAHalfDetectionTimes) {
    begin_under_load();
    world.broker(1).stop_core();
    const auto is_replaced = [&] {
        return world.broker(0).member().facts().take_overs +
                   world.broker(2).member().facts().take_overs ==
               1;
    };
    const Duration detection = world.options().cluster.detection_timeout;
    world.run_for(detection * 5 / 4);
    EXPECT_FALSE(is_replaced());
    EXPECT_TRUE(world.run_until(is_replaced, detection / 4 + 50ms));
    world.broker(1).go_on();
    world.run_for(1s);
    expect_all_promises_kept();
    expect_nobody_noticed();
}

// Its socket is the newest at its address: what its robots say would wait there, though the holder
// has the sessions still, or again.
TEST_F(StallScenario, ABrokerThatStopsWhileItIsHandedItsAddressIsReplacedThereAgain) {
    begin_under_load();
    for (Duration after = 0ms; after < 20ms; after += 500us) {
        world.broker(1).crash();
        world.run_for(200ms);
        world.broker(1).start();
        const auto is_back = [&] { return world.broker(1).member().view().members.size() == 3; };
        ASSERT_TRUE(world.run_until(is_back, 1s));
        world.run_for(after);
        world.broker(1).stop();
        world.run_for(600ms);  // robots repeat after 500 ms
        const Instant replaced = world.now();
        world.run_for(400ms);
        EXPECT_GT(acknowledged("robot1", replaced), 5) << "stopped after " << after / 1us << " us";
        world.broker(1).go_on();
        world.run_for(500ms);
    }
    expect_all_promises_kept();
    expect_nobody_noticed();
}

// Time in which it stands still is no time in which nobody came: alone it would tell the robots at
// its address that it does not know them.
TEST_F(StallScenario, ABrokerThatStopsBeforeItHasMetAnybodyWaitsForItsPeersAnew) {
    begin_under_load();
    for (Duration after = 100ms; after < 120ms; after += 1ms) {
        world.broker(1).crash();
        world.run_for(200ms);
        world.broker(1).start();
        world.run_for(after);
        world.broker(1).stop();
        world.run_for(2s);
        world.broker(1).go_on();
        const auto is_back = [&] { return !world.broker(1).member().view().members.empty(); };
        ASSERT_TRUE(world.run_until(is_back, 2s));
        EXPECT_EQ(world.broker(1).member().view().members.size(), 3U)
            << "stopped after " << after / 1ms << " ms";
        world.run_for(500ms);
    }
    expect_all_promises_kept();
    expect_nobody_noticed();
}

ClusterWorldOptions with_brokers_that_match_slowly() {
    ClusterWorldOptions options = with_patient_brokers();
    options.brokers = 4;
    options.peers.lease = 1s;
    options.peers.match_after_max = 400ms;
    return options;
}

class SlowMatchScenario : public ClusterScenario {
protected:
    SlowMatchScenario() : ClusterScenario(with_brokers_that_match_slowly()) {}
};

// Alone in a view it would go on for all its peers, whose clients hear everything twice then.
TEST_F(SlowMatchScenario, AReplacedBrokerWaitsForItsPeers) {
    add_one_each({Qos::at_least_once, Qos::exactly_once});
    begin();
    for (std::size_t round = 0; round < 6; ++round) {
        publish(true);
        world.run_for(300ms);
        world.broker(round % 3).stop();
        world.run_for(2s);
        world.broker(round % 3).go_on();
        world.run_for(2s);
        expect_all_promises_kept();
    }
    expect_nobody_noticed();
}

// It leads as soon as it has met one of them; the other may be the heir of a broker that died
// meanwhile.
TEST_F(SlowMatchScenario, AReplacedLeaderWaitsForThePeersOfItsPeers) {
    add_one_each({Qos::at_least_once, Qos::exactly_once});
    begin();
    for (std::size_t round = 0; round < 4; ++round) {
        publish(true);
        world.run_for(300ms);
        world.broker(0).stop();
        world.run_for(300ms);
        world.broker(1).crash();
        world.run_for(1700ms);
        world.broker(0).go_on();
        world.run_for(1s);
        world.broker(1).start();
        world.run_for(1s);
        expect_all_promises_kept();
    }
    expect_nobody_noticed();
}

}  // namespace
}  // namespace romano::sim::stall_scenarios_test
