// Brokers that were told different things: people learn of it by name, and a robot's topic ids
// never mean to its broker what another broker was told.

#include <gmock/gmock.h>

#include "tests/overlay/member/steps.h"

namespace romano::test::settings_comparison_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;
using mqttsn::TopicId;
using testing::ElementsAre;
using testing::IsEmpty;

class OtherMeanings : public testing::Test {
protected:
    OtherMeanings() {
        for (const int rank : {1, 2, 3}) brokers.predefine(rank, pose);
    }
    /// A robot at broker 1 that publishes under id 1, and others that listen at broker 3.
    void set_out() {
        at_pose = &subscriber(brokers, "map", 3, Qos::at_least_once, "robots/pose");
        at_stop = &subscriber(brokers, "motors", 3, Qos::at_least_once, "robots/stop");
        robot = &publisher(brokers, "robot", 1);
        say("before");
        ASSERT_THAT(at_pose->received(), ElementsAre("before"));
    }
    void say(const std::string& text) {
        robot->publish_predefined(TopicId{1}, text);
        brokers.run_for(1s);
    }

    const std::map<TopicId, std::string> pose{{TopicId{1}, "robots/pose"}};
    const std::map<TopicId, std::string> stop{{TopicId{1}, "robots/stop"}};
    Brokers brokers;
    Robot* at_pose = nullptr;
    Robot* at_stop = nullptr;
    Robot* robot = nullptr;
};

TEST_F(OtherMeanings, AreToldByNameOnceOnBothSides) {
    brokers.predefine(2, stop);
    start(brokers, {1, 2});
    brokers.run_for(20s);
    EXPECT_THAT(brokers.warnings(1),
                ElementsAre("the brokers disagree about predefined: b1 has '1=robots/pose', b2 has "
                            "'1=robots/stop'; give all brokers the same"));
    EXPECT_THAT(brokers.warnings(2),
                ElementsAre("the brokers disagree about predefined: b2 has '1=robots/stop', b1 has "
                            "'1=robots/pose'; give all brokers the same"));
}

TEST_F(OtherMeanings, NothingIsToldOfBrokersThatAgree) {
    start(brokers, {1, 2, 3});
    brokers.run_for(5s);
    EXPECT_THAT(brokers.warnings(1), IsEmpty());
    EXPECT_THAT(brokers.warnings(2), IsEmpty());
}

TEST_F(OtherMeanings, ABrokerWithTheSameOnesInherits) {
    brokers.predefine(2, stop);
    start(brokers, {1, 2, 3});
    set_out();
    brokers.kill(1);
    brokers.run_for(1s);
    say("after");
    EXPECT_EQ(brokers.server_of(1), 3);
    EXPECT_THAT(at_pose->received(), ElementsAre("before", "after"));
    EXPECT_THAT(at_stop->received(), IsEmpty());
    expect_unnoticed(*robot);
}

TEST_F(OtherMeanings, NobodyAnswersAtAnAddressWhoseBrokerHadOnesThatNobodyElseHas) {
    brokers.predefine(2, stop);
    brokers.predefine(3, stop);
    start(brokers, {1, 2, 3});
    set_out();
    brokers.kill(1);
    brokers.run_for(1s);
    say("after");
    robot->publish_without_connection(TopicId{1}, "and without a session");
    brokers.run_for(1s);
    EXPECT_EQ(brokers.server_of(1), 0);
    EXPECT_THAT(at_stop->received(), IsEmpty()) << "the pose arrives as stop";
    const std::string told =
        "nobody goes on for the clients of b1: no broker with its predefined topics is left";
    EXPECT_THAT(brokers.warnings(3), testing::Contains(told));
    brokers.kill(2);  // a further view
    brokers.run_for(45s);
    EXPECT_EQ(std::ranges::count(brokers.warnings(3), told), 1);
}

TEST_F(OtherMeanings, ABrokerThatComesBackWithOthersTakesNoSessionBack) {
    start(brokers, {1, 2, 3});
    set_out();
    brokers.kill(1);
    brokers.run_for(1s);
    brokers.predefine(1, stop);
    start(brokers, {1});
    ASSERT_EQ(brokers.server_of(1), 1);
    EXPECT_THAT(brokers.sessions_at(1), IsEmpty());
    say("after");
    EXPECT_THAT(at_stop->received(), IsEmpty()) << "the pose arrives as stop";
    EXPECT_GT(robot->rejections(), 0) << "it must connect anew";
}

TEST_F(OtherMeanings, ARobotIsAStrangerInTheCellOfABrokerWithOthers) {
    brokers.serve_one_address_in_every_cell();
    brokers.predefine(2, stop);
    start(brokers, {1, 2, 3});
    set_out();
    brokers.drive(*robot, 2);
    say("after");
    EXPECT_THAT(at_stop->received(), IsEmpty()) << "the pose arrives as stop";
    EXPECT_GT(robot->rejections(), 0) << "it must connect anew";
}

/// It connects anew there: the copy at its former home ends.
TEST_F(OtherMeanings, OneHomeIsLeftOfAClientThatConnectsAnewElsewhere) {
    brokers.serve_one_address_in_every_cell();
    brokers.predefine(2, stop);
    start(brokers, {1, 2, 3});
    set_out();
    brokers.drive(*robot, 2);
    robot->connect(false);
    brokers.run_for(2s);
    EXPECT_THAT(brokers.sessions_at(1), IsEmpty());
    EXPECT_THAT(brokers.sessions_at(2), ElementsAre("robot"));
}

}  // namespace
}  // namespace romano::test::settings_comparison_test
