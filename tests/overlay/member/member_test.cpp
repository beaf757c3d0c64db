// A cluster of members as its robots see it. P1..P8 are the promises of the design, section 4.

#include "overlay/member/member.h"

#include <gmock/gmock.h>

#include "tests/overlay/member/steps.h"

namespace romano::test::member_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;
using testing::UnorderedElementsAre;
using testing::UnorderedElementsAreArray;

TEST(Member, AloneItLeadsItselfAndServes) {
    Brokers brokers;
    start(brokers, {1});
    EXPECT_EQ(brokers.leader_of(1), 1);
    EXPECT_EQ(brokers.view_size(1), 1U);
    Robot& robot = subscriber(brokers, "robot", 1, Qos::exactly_once);
    robot.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(100ms);
    EXPECT_THAT(robot.received(), ElementsAre("1"));
}

TEST(Member, P1_StartedTogetherTheyFormOneViewUnderTheHighest) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    for (const int rank : {1, 2, 3}) {
        EXPECT_EQ(brokers.leader_of(rank), 3);
        EXPECT_EQ(brokers.view_size(rank), 3U);
        EXPECT_EQ(brokers.member(rank).view(), brokers.member(3).view());
    }
}

class EveryQos : public testing::TestWithParam<Qos> {};
INSTANTIATE_TEST_SUITE_P(Qos, EveryQos,
                         testing::Values(Qos::at_most_once, Qos::at_least_once, Qos::exactly_once));

TEST_P(EveryQos, P5_APublishCrossesBrokersInOrder) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& there = subscriber(brokers, "there", 1, GetParam());
    Robot& here = publisher(brokers, "here", 2);
    for (const auto& text : numbers(1, 20)) here.publish("pose", text, GetParam());
    brokers.run_for(1s);
    EXPECT_EQ(there.received(), numbers(1, 20));
}

TEST(Member, AJoinerGetsSessionsAndRetainedMessagesBySnapshot) {
    Brokers brokers;
    start(brokers, {2});
    Robot& robot = subscriber(brokers, "robot", 2, Qos::at_least_once);
    robot.publish("lamp", "on", Qos::at_least_once, true);
    brokers.run_for(200ms);
    start(brokers, {1});
    EXPECT_EQ(brokers.view_size(1), 2U);
    Robot& late = subscriber(brokers, "late", 1, Qos::at_least_once, "lamp");
    EXPECT_THAT(late.received(), ElementsAre("on"));
    brokers.kill(2);  // what the joiner knows is enough to take over
    brokers.run_for(settling);
    late.publish("pose", "1", Qos::at_least_once);
    brokers.run_for(500ms);
    EXPECT_THAT(robot.received(), ElementsAre("1"));
    expect_unnoticed(robot);
}

TEST_P(EveryQos, TheClientsOfADeadBrokerGoOnAtTheirAddress) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& orphan = subscriber(brokers, "orphan", 1, GetParam());
    Robot& other = publisher(brokers, "other", 2);
    other.publish("pose", "1", GetParam());
    brokers.run_for(200ms);
    brokers.kill(1);
    brokers.run_for(settling);
    EXPECT_NE(brokers.server_of(1), 0);
    other.publish("pose", "2", GetParam());
    orphan.publish("pose", "3", GetParam());
    brokers.run_for(1s);
    EXPECT_THAT(orphan.received(), UnorderedElementsAre("1", "2", "3"));
    EXPECT_THAT(orphan.topic_ids_seen(), SizeIs(1));
    expect_unnoticed(orphan);
}

TEST(Member, P2_P3_NothingAcknowledgedIsLostOrDoubledWhenAHomeDiesUnderLoad) {
    for (const int victim : {1, 2, 3}) {
        SCOPED_TRACE(victim);
        Brokers brokers;
        start(brokers, {1, 2, 3});
        std::vector<Robot*> robots;
        for (const int home : {1, 2, 3}) {
            const std::string name = "s" + std::to_string(home);
            robots.push_back(&subscriber(brokers, name, home, Qos::exactly_once));
        }
        for (const auto& text : numbers(1, 100)) {
            robots[0]->publish("pose", text, Qos::exactly_once);
        }
        brokers.run_for(60ms);
        brokers.kill(victim);
        brokers.run_for(6s);
        EXPECT_EQ(robots[0]->acknowledged(), 100U);
        for (const Robot* robot : robots) {
            EXPECT_EQ(robot->received(), numbers(1, 100));
            expect_unnoticed(*robot);
        }
    }
}

TEST(Member, P4_AfterATakeOverEachClientHasOneHome) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    for (const int home : {1, 2, 3}) {
        subscriber(brokers, "s" + std::to_string(home), home, Qos::at_least_once);
    }
    brokers.kill(3);
    brokers.run_for(settling);
    auto all = brokers.sessions_at(1);
    for (const auto& client : brokers.sessions_at(2)) all.push_back(client);
    EXPECT_THAT(all, UnorderedElementsAre("s1", "s2", "s3"));
}

TEST(Member, TwoBrokersDieOneAfterTheOther) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 3, Qos::exactly_once);
    Robot& other = subscriber(brokers, "other", 1, Qos::exactly_once);
    brokers.kill(3);
    brokers.run_for(settling);
    other.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(300ms);
    brokers.kill(2);
    brokers.run_for(settling);
    other.publish("pose", "2", Qos::exactly_once);
    brokers.run_for(1s);
    EXPECT_THAT(robot.received(), ElementsAre("1", "2"));
    EXPECT_THAT(brokers.sessions_at(1), UnorderedElementsAre("robot", "other"));
    expect_unnoticed(robot);
}

TEST(Member, AReturningBrokerIsHandedItsAddressAndItsSessions) {
    Brokers brokers;
    start(brokers, {1, 2});
    Robot& robot = subscriber(brokers, "robot", 1, Qos::exactly_once);
    brokers.kill(1);
    brokers.run_for(settling);
    ASSERT_EQ(brokers.server_of(1), 2);
    brokers.start(1);
    for (const auto& text : numbers(1, 40)) {
        robot.publish("pose", text, Qos::exactly_once);
        brokers.run_for(50ms);
    }
    brokers.run_for(settling);
    EXPECT_EQ(brokers.server_of(1), 1);
    EXPECT_THAT(brokers.sessions_at(1), ElementsAre("robot"));
    EXPECT_THAT(brokers.sessions_at(2), IsEmpty());
    EXPECT_EQ(robot.received(), numbers(1, 40));
    expect_unnoticed(robot);
}

TEST(Member, ASessionThatWasHandedBackGetsQos0FromPeers) {
    Brokers brokers;
    start(brokers, {1, 2});
    Robot& robot = subscriber(brokers, "robot", 1, Qos::at_most_once);
    Robot& other = subscriber(brokers, "other", 2, Qos::at_least_once, "lamp");
    brokers.kill(1);
    brokers.run_for(settling);
    other.publish("lamp", "on", Qos::at_least_once);  // the sessions' home is ahead in a log
    brokers.start(1);
    brokers.run_for(settling);
    ASSERT_THAT(brokers.sessions_at(1), ElementsAre("robot"));
    other.publish("pose", "1", Qos::at_most_once);
    brokers.run_for(100ms);
    EXPECT_THAT(robot.received(), ElementsAre("1"));
}

TEST(Member, ABrokerThatHasJustStartedKeepsItsAddress) {
    Brokers brokers;
    brokers.start(1);
    brokers.start(2);
    for (int i = 0; i < 500; ++i) {
        brokers.run_for(1ms);
        ASSERT_EQ(brokers.server_of(1), 1);
        ASSERT_EQ(brokers.server_of(2), 2);
    }
}

TEST(Member, ABrokerThatRestartsFasterThanItIsMissedGetsItsSessionsBack) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 1, Qos::exactly_once);
    brokers.kill(1);
    brokers.run_for(20ms);
    brokers.start(1);
    brokers.run_for(30ms);
    robot.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(2s);
    EXPECT_EQ(brokers.server_of(1), 1);
    EXPECT_THAT(brokers.sessions_at(1), ElementsAre("robot"));
    EXPECT_THAT(robot.received(), ElementsAre("1"));
    expect_unnoticed(robot);
}

TEST(Member, AnOrderlyStopHandsOverAtOnce) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 3, Qos::at_least_once);
    brokers.leave(3);
    brokers.run_for(20ms);  // far below the detection time
    EXPECT_NE(brokers.server_of(3), 0);
    robot.publish("pose", "1", Qos::at_least_once);
    brokers.run_for(1s);
    EXPECT_THAT(robot.received(), ElementsAre("1"));
    expect_unnoticed(robot);
}

overlay::MemberOptions b1_alone() {
    return {.broker = {},
            .cluster = {},
            .name = "b1",
            .incarnation = 1,
            .home_addresses = {broker_address(1)}};
}

TEST(Member, WhatComesFromTheShellAfterAnOrderlyStopCallsNobodyBack) {
    overlay::Member member{b1_alone(), 1};
    overlay::MemberActions actions;
    const Instant now{1s};
    member.on_tick(now, actions);
    member.leave(now, actions);
    actions = {};
    member.on_address(now + 1ms, broker_address(1), true, actions);
    member.on_tick(now + 1s, actions);
    EXPECT_TRUE(actions.peers.empty());
    EXPECT_TRUE(actions.local.empty());
    EXPECT_TRUE(actions.clients.empty());
    EXPECT_EQ(member.next_wakeup(), never);
}

// Taking the address took long, and others may have gone on meanwhile.
TEST(Member, P3_WhatCameWhileAnAddressWasTakenIsNotAnswered) {
    overlay::Member member{b1_alone(), 1};
    overlay::MemberActions actions;
    Instant now{1s};
    member.on_tick(now, actions);
    now += 1s;
    member.on_address(now, broker_address(1), true, actions);
    constexpr std::uint8_t connect[] = {7, 0x04, 0x04, 1, 0, 60, 'r'};
    member.on_datagram(now, broker_address(1), broker_address(9), connect, actions);
    for (int i = 0; i < 1'000 && !member.cluster().is_in_view(); ++i) {
        member.on_tick(now += 10ms, actions);
    }
    ASSERT_TRUE(member.cluster().is_in_view());
    EXPECT_EQ(member.broker().session_count(), 0U);
}

TEST(Member, FormerLivesOfABrokerAreForgotten) {  // P8
    Brokers brokers;
    start(brokers, {1, 2});
    subscriber(brokers, "robot", 1, Qos::exactly_once);
    Robot& talker = publisher(brokers, "talker", 2);
    for (int life = 0; life < 10; ++life) {
        brokers.kill(2);
        brokers.run_for(300ms);
        brokers.start(2);
        brokers.run_for(1s);
        ASSERT_EQ(brokers.server_of(2), 2);
        talker.publish("pose", std::to_string(life), Qos::at_least_once);
        brokers.run_for(200ms);
    }
    const auto logs_known = [&] {
        return brokers.member(1).broker().image("robot")->worked_through.size();
    };
    EXPECT_GE(logs_known(), 10U);  // while their sessions may still be on their way
    brokers.run_for(61s);          // 600 detection times, and the next turn
    EXPECT_LE(logs_known(), 2U);
}

TEST(Member, AReturningBrokerOfTheHighestRankTakesOnlyWhatIsItsOwn) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 1, Qos::exactly_once);
    brokers.kill(3);
    brokers.run_for(settling);
    brokers.start(3);
    for (int i = 0; i < 500; ++i) {
        brokers.run_for(1ms);
        ASSERT_EQ(brokers.server_of(1), 1);
        ASSERT_EQ(brokers.server_of(2), 2);
    }
    EXPECT_EQ(brokers.leader_of(1), 3);
    EXPECT_THAT(brokers.sessions_at(3), IsEmpty());
    expect_unnoticed(robot);
}

TEST(Member, P4_AClientThatConnectsElsewhereTakesItsSessionAlong) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 1, Qos::exactly_once);
    Robot& other = publisher(brokers, "other", 3);
    robot.move_to(broker_address(2));
    robot.connect(false);
    brokers.run_for(200ms);
    EXPECT_THAT(brokers.sessions_at(1), IsEmpty());
    EXPECT_THAT(brokers.sessions_at(2), ElementsAre("robot"));
    other.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(500ms);
    EXPECT_THAT(robot.received(), ElementsAre("1"));
}

TEST(Member, ARoamingClientIsServedWithoutAnyConnect) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 1, Qos::exactly_once);
    goes_on_at(brokers, robot, 2);
}

TEST(Member, WhoRoamsOnBeforeItsSessionFollowedIsNoStranger) {
    for (const auto stay : {0ms, 1ms, 2ms, 3ms, 4ms, 5ms}) {
        SCOPED_TRACE(stay.count());
        Brokers brokers;
        start(brokers, {1, 2, 3});
        Robot& robot = subscriber(brokers, "robot", 1, Qos::exactly_once);
        robot.move_to(broker_address(2));
        robot.publish("pose", "on the way", Qos::at_most_once);
        brokers.run_for(stay);
        robot.move_to(broker_address(3));
        robot.publish("pose", "there", Qos::exactly_once);
        brokers.run_for(500ms);
        EXPECT_THAT(robot.received(), Contains("there"));
        EXPECT_THAT(brokers.sessions_at(3), ElementsAre("robot"));
        expect_unnoticed(robot);
    }
}

/// It comes to its holder's own address amid the hand-over: both would deliver its messages
/// (simulator, seed 414907).
TEST(Member, P3_WhoRoamsToTheHolderWhileItsSessionIsHandedBackHasOneHome) {
    for (int moves_after = 25; moves_after < 45; ++moves_after) {
        SCOPED_TRACE(std::to_string(moves_after) + " ms after the owner's start");
        Brokers brokers;
        start(brokers, {1, 2, 3});
        Robot& robot = subscriber(brokers, "robot", 2, Qos::exactly_once);
        Robot& other = publisher(brokers, "other", 1);
        brokers.kill(2);
        brokers.run_for(500ms);
        const int holder = brokers.server_of(2);
        brokers.start(2);
        brokers.run_for(std::chrono::milliseconds{moves_after});
        robot.move_to(broker_address(holder));
        robot.publish("pose", "0", Qos::exactly_once);
        for (const auto& text : numbers(1, 20)) {
            other.publish("pose", text, Qos::exactly_once);
            brokers.run_for(5ms);
        }
        brokers.run_for(1s);
        EXPECT_THAT(robot.received(), UnorderedElementsAreArray(numbers(0, 20)));
        EXPECT_THAT(brokers.sessions_at(holder), Contains("robot"));
        expect_unnoticed(robot);
    }
}

TEST(Member, StrictAcknowledgementRefusesWhatALoneBrokerCannotKeep) {
    cluster::ClusterOptions strict;
    strict.acks_strict = true;
    Brokers brokers(strict);
    start(brokers, {1});
    Robot& robot = brokers.robot("robot", 1);
    robot.connect();
    brokers.run_for(300ms);
    EXPECT_THAT(brokers.sessions_at(1), IsEmpty());
    brokers.start(2);
    brokers.run_for(settling);
    robot.connect();
    brokers.run_for(300ms);
    EXPECT_THAT(brokers.sessions_at(1), ElementsAre("robot"));
}

TEST(Member, ADeadPeerBlocksNobodyLongerThanOneDetectionTime) {
    Brokers brokers;
    start(brokers, {1, 2});
    Robot& robot = subscriber(brokers, "robot", 2, Qos::at_least_once);
    brokers.kill(1);
    robot.publish("pose", "1", Qos::at_least_once);
    brokers.run_for(150ms);
    EXPECT_EQ(robot.acknowledged(), 1U);
}

TEST(Member, AllButOneDieAndTheLastServesEverybody) {
    Brokers brokers;
    start(brokers, {1, 2, 3, 4, 5});
    std::vector<Robot*> robots;
    for (const int home : {1, 2, 3, 4, 5}) {
        const std::string name = "s" + std::to_string(home);
        robots.push_back(&subscriber(brokers, name, home, Qos::exactly_once));
    }
    for (const int victim : {5, 4, 3, 2}) {
        brokers.kill(victim);
        robots[0]->publish("pose", std::to_string(victim), Qos::exactly_once);
        brokers.run_for(settling);
    }
    for (const Robot* robot : robots) {
        EXPECT_THAT(robot->received(), ElementsAre("5", "4", "3", "2"));
        expect_unnoticed(*robot);
    }
    EXPECT_EQ(brokers.member(1).broker().session_count(), 5U);
}

}  // namespace
}  // namespace romano::test::member_test
