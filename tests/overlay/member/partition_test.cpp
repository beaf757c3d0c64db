// Robots on the two sides of a partition, and after it. P1..P8 are the promises of the design,
// section 4.

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "tests/overlay/member/steps.h"

namespace romano::test::partition_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::MsgType;
using mqttsn::Qos;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

TEST(Member, P6_BothSidesOfAPartitionServeAndMergeWhenItHeals) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& left = subscriber(brokers, "left", 1, Qos::exactly_once);
    Robot& right = subscriber(brokers, "right", 3, Qos::exactly_once);
    brokers.cut(1, 2);
    brokers.cut(1, 3);
    brokers.run_for(settling);
    EXPECT_EQ(brokers.view_size(1), 1U);
    EXPECT_EQ(brokers.view_size(3), 2U);
    brokers.heal();
    brokers.run_for(2s);
    for (const int rank : {1, 2, 3}) {
        EXPECT_EQ(brokers.view_size(rank), 3U);
        EXPECT_EQ(brokers.leader_of(rank), 3);
        EXPECT_EQ(brokers.server_of(rank), rank) << "every broker has its own address again";
    }
    EXPECT_THAT(brokers.sessions_at(1), ElementsAre("left"));
    EXPECT_THAT(brokers.sessions_at(2), IsEmpty());
    EXPECT_THAT(brokers.sessions_at(3), ElementsAre("right"));
    left.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(1s);
    EXPECT_THAT(left.received(), ElementsAre("1"));
    EXPECT_THAT(right.received(), ElementsAre("1"));
    expect_unnoticed(left);
    expect_unnoticed(right);
}

// The robot's broker and broker 2 hear each other all the time; broker 3 alone took the robot over.
TEST(Member, ARoamingClientIsFoundThoughAnHeirThatWasCutOffHadItMeanwhile) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 1, Qos::exactly_once);
    brokers.cut(1, 3);
    brokers.cut(2, 3);
    brokers.run_for(settling);
    ASSERT_THAT(brokers.sessions_at(3), ElementsAre("robot"));
    brokers.heal();
    brokers.run_for(settling);
    ASSERT_THAT(brokers.sessions_at(3), IsEmpty());
    goes_on_at(brokers, robot, 2);
}

// Each side holds it under another address, and both addresses go back to their owners at the heal.
TEST(Member, P4_AClientThatRoamedInAPartitionHasOneHomeAfterIt) {
    Brokers brokers;
    start(brokers, {1, 2});
    Robot& robot = subscriber(brokers, "robot", 2, Qos::exactly_once);
    brokers.cut(1, 2);
    brokers.run_for(settling);
    ASSERT_THAT(brokers.sessions_at(1), ElementsAre("robot"));
    robot.move_to(broker_address(1));
    robot.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(200ms);
    ASSERT_THAT(robot.received(), ElementsAre("1"));
    brokers.heal();
    brokers.run_for(settling);
    EXPECT_EQ(brokers.sessions_at(1).size() + brokers.sessions_at(2).size(), 1U);
    robot.publish("pose", "2", Qos::exactly_once);
    brokers.run_for(500ms);
    EXPECT_THAT(robot.received(), ElementsAre("1", "2"));
    expect_unnoticed(robot);
}

TEST(Member, P3_WhatWasPublishedOnEitherSideOfAPartitionComesOnceToAll) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    std::vector<Robot*> robots;
    for (const int home : {1, 2, 3}) {
        const std::string name = "s" + std::to_string(home);
        robots.push_back(&subscriber(brokers, name, home, Qos::exactly_once));
    }
    brokers.cut(1, 2);
    brokers.cut(1, 3);
    std::vector<std::string> all;
    for (int i = 0; i < 20; ++i) {
        for (const std::size_t talker : {0U, 2U}) {
            all.push_back(std::to_string(talker) + ":" + std::to_string(i));
            robots[talker]->publish("pose", all.back(), Qos::exactly_once);
        }
        brokers.run_for(100ms);
    }
    brokers.heal();
    brokers.run_for(3s);
    for (const Robot* robot : robots) {
        EXPECT_THAT(robot->received(), testing::UnorderedElementsAreArray(all));
        expect_unnoticed(*robot);
    }
}

TEST(Member, P2_ClientsThatGoWithTheirAddressGetWhatBothSidesPublished) {
    // The robot of broker 1 stands beside broker 2: in the partition it talks to 1's heir.
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& far = brokers.robot("far", 2);
    far.move_to(broker_address(1));
    far.connect();
    far.subscribe("pose", Qos::exactly_once);
    Robot& left = publisher(brokers, "left", 1);
    Robot& right = publisher(brokers, "right", 3);
    brokers.run_for(200ms);
    brokers.cut(1, 2);
    brokers.cut(1, 3);
    std::vector<std::string> all;
    for (int i = 0; i < 20; ++i) {
        all.push_back("l" + std::to_string(i));
        left.publish("pose", all.back(), Qos::exactly_once);
        all.push_back("r" + std::to_string(i));
        right.publish("pose", all.back(), Qos::exactly_once);
        if (i % 5 == 0) far.publish("lamp", "on", Qos::at_least_once);
        brokers.run_for(100ms);
    }
    brokers.heal();
    brokers.run_for(3s);
    EXPECT_THAT(far.received(), testing::UnorderedElementsAreArray(all));
    EXPECT_EQ(far.count_sent(MsgType::connect), 1);
    EXPECT_EQ(far.rejections(), 0);
    EXPECT_THAT(brokers.sessions_at(1), UnorderedElementsAre("far", "left"));
}

TEST(Member, P4_AClientThatBothSidesHeardKeepsOneSessionAfterTheHeal) {
    // It stands beside 2 and goes there in the partition: 2's copy is newer, and its address 1's.
    Brokers brokers;
    start(brokers, {1, 2});
    Robot& robot = brokers.robot("robot", 2);
    robot.move_to(broker_address(1));
    robot.connect();
    robot.subscribe("pose", Qos::exactly_once);
    brokers.run_for(200ms);
    brokers.cut(1, 2);
    brokers.run_for(settling);
    robot.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(300ms);
    brokers.heal();
    for (const auto& text : numbers(2, 20)) {
        robot.publish("pose", text, Qos::exactly_once);
        brokers.run_for(30ms);
    }
    brokers.run_for(2s);
    EXPECT_EQ(robot.received(), numbers(1, 20));
    EXPECT_THAT(brokers.sessions_at(1), ElementsAre("robot"));
    EXPECT_THAT(brokers.sessions_at(2), IsEmpty());
    expect_unnoticed(robot);
}

}  // namespace
}  // namespace romano::test::partition_test
