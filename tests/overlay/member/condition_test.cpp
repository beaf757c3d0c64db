// Battery and load in the rank: who is low on battery gives up the lead, and no client notices.

#include "overlay/cluster/agreement/condition.h"

#include <gmock/gmock.h>

#include "tests/overlay/member/steps.h"

namespace romano::test::condition_test {
namespace {

using namespace std::chrono_literals;
using cluster::Condition;
using mqttsn::Qos;
using testing::ElementsAre;
using testing::ElementsAreArray;

class Batteries : public testing::TestWithParam<const char*> {
protected:
    static cluster::ClusterOptions options() {
        cluster::ClusterOptions options;
        options.elector = GetParam();
        return options;
    }
    [[nodiscard]] bool all_follow(int leader) const {
        for (const int rank : {1, 2, 3}) {
            if (brokers.leader_of(rank) != leader || brokers.view_size(rank) != 3) return false;
        }
        return true;
    }

    Brokers brokers{options()};
};

TEST_P(Batteries, OneThatIsLowOnBatteryGivesUpTheLeadWithoutAFault) {
    brokers.make_equally_capable();
    start(brokers, {1, 2, 3});
    const int first = brokers.leader_of(1);
    ASSERT_TRUE(all_follow(first));
    Robot& listener = subscriber(brokers, "listener", first, Qos::exactly_once);
    Robot& talker = publisher(brokers, "talker", first);
    for (int i = 1; i <= 40; ++i) {
        if (i == 10) brokers.read_battery(first, 20);
        talker.publish("pose", std::to_string(i), Qos::exactly_once);
        brokers.run_for(50ms);
    }
    brokers.run_for(1s);
    const int next = brokers.leader_of(first);
    EXPECT_NE(next, first);
    EXPECT_TRUE(all_follow(next));
    EXPECT_THAT(listener.received(), ElementsAreArray(numbers(1, 40)));
    EXPECT_EQ(brokers.server_of(first), first) << "no failover";
    expect_unnoticed(listener);
    expect_unnoticed(talker);
}

TEST_P(Batteries, CapabilityComesBeforeThem) {
    start(brokers, {1, 2, 3});
    ASSERT_TRUE(all_follow(3));
    brokers.read_battery(3, 1);
    brokers.run_for(1s);
    EXPECT_TRUE(all_follow(3));
}

TEST_P(Batteries, TheLeadComesBackWhenItIsCharged) {
    brokers.make_equally_capable();
    start(brokers, {1, 2, 3});
    const int first = brokers.leader_of(1);
    brokers.read_battery(first, 10);
    brokers.run_for(1s);
    EXPECT_FALSE(all_follow(first));
    brokers.read_battery(first, 100);
    brokers.run_for(1s);
    EXPECT_TRUE(all_follow(first));
}

INSTANTIATE_TEST_SUITE_P(Electors, Batteries, testing::Values("component", "bully"),
                         [](const auto& test) { return std::string(test.param); });

TEST(Condition, IsToldInStepsAndDoesNotSwing) {
    Condition condition;
    EXPECT_EQ(condition.told(), 100U) << "no battery is a full one";
    EXPECT_FALSE(condition.on_reading(97));
    EXPECT_TRUE(condition.on_reading(94));
    EXPECT_EQ(condition.told(), 75U);
    for (const std::uint32_t reading : {75U, 74U, 71U, 76U, 70U, 99U, 94U, 78U}) {
        EXPECT_FALSE(condition.on_reading(reading)) << reading;
    }
    EXPECT_TRUE(condition.on_reading(69));
    EXPECT_EQ(condition.told(), 50U);
    EXPECT_FALSE(condition.on_reading(79));
    EXPECT_TRUE(condition.on_reading(80));
    EXPECT_EQ(condition.told(), 75U);
    EXPECT_TRUE(condition.on_reading(100)) << "charged";
    EXPECT_TRUE(condition.on_reading(3));
    EXPECT_EQ(condition.told(), 0U);
    EXPECT_TRUE(condition.on_reading(1'000'000));
    EXPECT_EQ(condition.told(), 100U);
}

/// Two that drain together change the lead a few times in all, not at each percent.
TEST(Condition, TwoBatteriesThatDrainTogetherChangeTheLeadAFewTimes) {
    Condition a;
    Condition b;
    int changes = 0;
    bool a_leads = true;
    for (std::uint32_t left = 1'000; left-- > 0;) {
        a.on_reading(left / 10);
        b.on_reading((left + 7) / 10);
        const bool leads = a.told() >= b.told();
        if (leads != a_leads) ++changes;
        a_leads = leads;
    }
    EXPECT_LE(changes, 8);
}

TEST(Abilities, AnAddressGoesToOneWhoseMachineCanServeIt) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 1, Qos::exactly_once);
    (void)publisher(brokers, "other", 3);  // 2 has less to do
    brokers.forbid(2, 1);
    brokers.kill(1);
    brokers.run_for(1s);
    EXPECT_EQ(brokers.server_of(1), 3);
    robot.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(200ms);
    EXPECT_THAT(robot.received(), ElementsAre("1"));
    expect_unnoticed(robot);
}

}  // namespace
}  // namespace romano::test::condition_test
