// One broker, shipped client cores and bad links: MQTT-SN's own rules before any cluster.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "overlay/sim/lone_world.h"
#include "overlay/sim/promises.h"
#include "tests/overlay/sim/traced.h"

namespace romano::sim::lone_broker_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

constexpr LinkQuality good{};
const LinkQuality bad{
    .delay_min = 1ms, .delay_max = 30ms, .loss_ppm = 200'000, .duplication_ppm = 50'000};

RobotOptions talker(const std::string& topic, std::vector<Qos> qos) {
    RobotOptions options;
    options.name = "talker";
    options.topics = {topic};
    options.qos = std::move(qos);
    return options;
}

RobotOptions listener(const std::string& filter, Qos qos) {
    RobotOptions options;
    options.name = "listener";
    options.subscriptions = {{filter, qos}};
    return options;
}

Violations judged(const World& world) {
    Violations violations;
    judge_safety(world.ledger(), {}, violations);
    judge_completeness(world.ledger(), {}, violations);
    return violations;
}

std::size_t received(const World& world, const std::string& subscriber) {
    return static_cast<std::size_t>(
        std::ranges::count(world.ledger().receptions, subscriber, &Reception::subscriber));
}

/// Everybody starts, publishes for `while_publishing` over bad links, and comes to rest.
void run_over_bad_links(LoneWorld& world, Duration while_publishing) {
    for (std::size_t i = 0; i < world.robot_count(); ++i) world.robot(i).start();
    ASSERT_TRUE(world.run_until([&] { return world.robots_are_idle(); }, 10s));
    world.clients().set_quality(bad);
    for (std::size_t i = 0; i < world.robot_count(); ++i) world.robot(i).begin_publishing();
    world.run_for(while_publishing);
    for (std::size_t i = 0; i < world.robot_count(); ++i) world.robot(i).end_publishing();
    world.clients().set_quality(good);
    ASSERT_TRUE(world.run_until([&] { return world.robots_are_idle(); }, 30s));
    world.run_for(10s);
}

class LoneBrokerBySeed : public testing::TestWithParam<std::uint64_t> {};

TEST_P(LoneBrokerBySeed, DeliversAllInOrderAndQos2OnceOverBadLinks) {
    LoneWorld world(GetParam());
    trace_if_asked(world);
    world.add_robot(talker("pose", {Qos::exactly_once}));
    RobotOptions second = talker("map/a", {Qos::at_least_once, Qos::exactly_once});
    second.name = "second";
    second.subscriptions = {{"pose", Qos::exactly_once}};
    world.add_robot(second);
    world.add_robot(listener("#", Qos::exactly_once));
    run_over_bad_links(world, 20s);
    EXPECT_GT(received(world, "listener"), 20U);
    EXPECT_EQ(to_text(judged(world)), "") << "seed " << GetParam();
}

INSTANTIATE_TEST_SUITE_P(Seeds, LoneBrokerBySeed, testing::Range<std::uint64_t>(1, 13));

TEST(LoneBroker, TheSameSeedGivesTheSameTrace) {
    const auto hash_of = [](std::uint64_t seed) {
        LoneWorld world(seed);
        world.add_robot(talker("pose", {Qos::at_least_once, Qos::exactly_once}));
        world.add_robot(listener("pose", Qos::exactly_once));
        run_over_bad_links(world, 5s);
        return world.trace().hash();
    };
    EXPECT_EQ(hash_of(1), hash_of(1));
    EXPECT_NE(hash_of(1), hash_of(2));
}

TEST(LoneBroker, KeepsMessagesForAClientThatIsAwayWithAKeptSession) {
    LoneWorld world(1);
    trace_if_asked(world);
    Robot& talks = world.add_robot(talker("pose", {}));
    RobotOptions kept = listener("pose", Qos::exactly_once);
    kept.clean_session = false;
    Robot& listens = world.add_robot(kept);
    talks.start();
    listens.start();
    world.run_for(1s);
    world.clients().cuts().cut_both(listens.options().node, world.broker_node(0), world.now());
    for (int i = 0; i < 5; ++i) talks.publish("pose", Qos::exactly_once);
    world.run_for(10s);
    EXPECT_EQ(received(world, "listener"), 0U);
    world.clients().cuts().join_all();
    ASSERT_TRUE(world.run_until([&] { return received(world, "listener") == 5; }, 30s));
    EXPECT_EQ(to_text(judged(world)), "");
}

TEST(LoneBroker, PublishesTheWillOfASilentClientOnce) {
    LoneWorld world(1);
    trace_if_asked(world);
    RobotOptions mortal = talker("pose", {});
    mortal.will_topic = "wills";
    mortal.keep_alive = 2s;
    Robot& dies = world.add_robot(mortal);
    RobotOptions watches = listener("wills", Qos::exactly_once);
    watches.keep_alive = 2s;
    world.add_robot(watches).start();
    dies.start();
    world.run_for(20s);
    EXPECT_TRUE(world.ledger().wills.empty());
    dies.switch_off();
    world.run_for(20s);
    EXPECT_EQ(world.ledger().wills.size(), 1U);
    EXPECT_EQ(to_text(judged(world)), "");
}

TEST(LoneBroker, GivesANewSubscriberTheRetainedMessage) {
    LoneWorld world(1);
    trace_if_asked(world);
    Robot& talks = world.add_robot(talker("pose", {}));
    Robot& listens = world.add_robot(listener("pose", Qos::exactly_once));
    talks.start();
    world.run_for(1s);
    talks.publish("pose", Qos::at_least_once, true);
    talks.publish("pose", Qos::exactly_once, true);
    world.run_for(1s);
    listens.start();
    world.run_for(1s);
    ASSERT_EQ(world.ledger().receptions.size(), 1U);
    EXPECT_EQ(world.ledger().receptions[0].number, 2U);
    EXPECT_TRUE(world.ledger().receptions[0].retain);
}

TEST(LoneBroker, GoesOnAfterItWasStopped) {
    LoneWorld world(1);
    trace_if_asked(world);
    Robot& talks = world.add_robot(talker("pose", {Qos::exactly_once}));
    Robot& listens = world.add_robot(listener("pose", Qos::exactly_once));
    talks.start();
    listens.start();
    world.run_for(1s);
    talks.begin_publishing();
    world.run_for(1s);
    world.broker().stop();
    world.run_for(2s);
    world.broker().go_on();
    world.run_for(1s);
    talks.end_publishing();
    world.run_for(10s);
    EXPECT_EQ(to_text(judged(world)), "");
    EXPECT_EQ(talks.connects(), 1U);
    EXPECT_EQ(listens.connects(), 1U);
}

}  // namespace
}  // namespace romano::sim::lone_broker_test
