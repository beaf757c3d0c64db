// Two robots with one address, at two brokers: a NAT that keeps source ports, or a robot that was
// started again under another id. Neither ever speaks with the other one's session.

#include <gmock/gmock.h>

#include "tests/overlay/member/steps.h"

namespace romano::test::shared_address_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;
using testing::ElementsAre;
using testing::IsEmpty;

/// "a" talks to broker 1, "b" to broker 3. Each publishes on a topic of its own, under the same
/// topic id, and hears one.
class MembersShareAnAddress : public testing::Test {
protected:
    void SetUp() override {
        start(brokers, {1, 2, 3});
        watcher.connect();
        watcher.subscribe("from/a", Qos::exactly_once);
        watcher.subscribe("from/b", Qos::exactly_once);
        for (Robot* robot : {&a, &b}) robot->connect();
        b.subscribe("to/b", Qos::exactly_once);
        a.subscribe("to/a", Qos::exactly_once);
        brokers.run_for(500ms);
        go_on("1");
        expect_heard({"a1", "b1"});
    }
    void go_on(const std::string& text) {
        a.publish("from/a", "a" + text, Qos::exactly_once);
        b.publish("from/b", "b" + text, Qos::exactly_once);
        watcher.publish("to/a", "a" + text, Qos::exactly_once);
        watcher.publish("to/b", "b" + text, Qos::exactly_once);
        brokers.run_for(1s);
    }
    void expect_heard(const std::vector<std::string>& texts) {
        EXPECT_THAT(watcher.received(), testing::UnorderedElementsAreArray(texts));
        for (const Robot* robot : {&a, &b}) {
            std::vector<std::string> own;
            for (const std::string& text : texts) {
                if (text[0] == (robot == &a ? 'a' : 'b')) own.push_back(text);
            }
            EXPECT_EQ(robot->received(), own);
            EXPECT_EQ(robot->rejections(), 0);
        }
    }

    Brokers brokers;
    Robot& watcher = brokers.robot("watcher", 2);
    Robot& a = brokers.robot("a", 1);
    Robot& b = brokers.robot_beside(a, "b", 3);
};

TEST_F(MembersShareAnAddress, AndGoOnWhenOneOfTheirBrokersDiesAndComesBack) {
    brokers.kill(3);
    brokers.run_for(500ms);
    go_on("2");
    brokers.start(3);
    brokers.run_for(settling);
    go_on("3");
    expect_heard({"a1", "b1", "a2", "b2", "a3", "b3"});
    EXPECT_EQ(brokers.sessions_at(1), std::vector<std::string>{"a"});
    EXPECT_EQ(brokers.sessions_at(3), std::vector<std::string>{"b"});
}

TEST_F(MembersShareAnAddress, AndGoOnWhenBothTheirBrokersHaveOneHeir) {
    brokers.kill(3);
    brokers.run_for(500ms);
    brokers.kill(1);
    brokers.run_for(500ms);
    go_on("2");
    expect_heard({"a1", "b1", "a2", "b2"});
}

TEST_F(MembersShareAnAddress, AndGoOnAcrossACutAndItsHeal) {
    brokers.cut(1, 3);
    brokers.cut(2, 3);
    brokers.run_for(500ms);
    brokers.heal();
    brokers.run_for(settling);
    go_on("2");
    expect_heard({"a1", "b1", "a2", "b2"});
}

// Whoever comes to a third broker without a word may be the one or the other.
TEST_F(MembersShareAnAddress, AndWhoRoamsIsAskedWhoItIs) {
    b.move_to(broker_address(2));
    b.publish("from/b", "whose?", Qos::at_most_once);
    brokers.run_for(500ms);
    EXPECT_EQ(b.rejections(), 1);
    EXPECT_THAT(watcher.received(), testing::UnorderedElementsAre("a1", "b1"));
    b.connect(false);
    brokers.run_for(500ms);
    EXPECT_EQ(brokers.sessions_at(1), std::vector<std::string>{"a"});
    go_on("2");
    EXPECT_THAT(a.received(), ElementsAre("a1", "a2"));
    EXPECT_THAT(b.received(), ElementsAre("b1", "b2"));
}

/// A robot that is started again at its port under another id, and finds another broker.
struct StartedAgain {
    explicit StartedAgain(std::uint16_t keep_alive_s) {
        start(brokers, {1, 2, 3});
        watcher.connect();
        watcher.subscribe("gone", Qos::exactly_once);
        former.connect_with_will("gone", keep_alive_s);
        brokers.run_for(500ms);
    }
    Robot& starts_again(int broker) {
        Robot& robot = brokers.robot_beside(former, "again", broker);
        robot.connect();
        robot.subscribe("pose", Qos::exactly_once);
        brokers.run_for(500ms);
        return robot;
    }
    void expect_lives(Robot& robot, const std::string& text) {
        watcher.publish("pose", text, Qos::exactly_once);
        brokers.run_for(500ms);
        EXPECT_THAT(robot.received(), testing::Contains(text));
        EXPECT_EQ(robot.rejections(), 0);
    }

    Brokers brokers;
    Robot& watcher = brokers.robot("watcher", 2);
    Robot& former = brokers.robot("former", 3);
};

TEST(RobotStartedAgainUnderAnotherId, P7_LivesWhenItsFormerSessionIsTakenOver) {
    StartedAgain scene{4};
    Robot& again = scene.starts_again(1);
    scene.brokers.kill(3);
    scene.brokers.run_for(500ms);
    scene.expect_lives(again, "1");
    EXPECT_THAT(scene.watcher.received(), IsEmpty());
    scene.brokers.run_for(8s);
    EXPECT_THAT(scene.watcher.received(), ElementsAre("former")) << "its will, once";
    scene.expect_lives(again, "2");
}

TEST(RobotStartedAgainUnderAnotherId, IsWhoSpeaksThereToTheHeirOfBothSessions) {
    StartedAgain scene{0};  // keep-alive 0: the former one is never lost
    Robot& again = scene.starts_again(3);
    for (const int dies : {3, 1}) {
        scene.brokers.kill(dies);
        scene.brokers.run_for(500ms);
        scene.expect_lives(again, std::to_string(dies));
        again.publish("pose", "own", Qos::exactly_once);
        scene.brokers.run_for(500ms);
        EXPECT_EQ(again.rejections(), 0);
        scene.brokers.start(dies);
        scene.brokers.run_for(settling);
        scene.expect_lives(again, "back " + std::to_string(dies));
    }
    EXPECT_THAT(scene.watcher.received(), IsEmpty());
}

}  // namespace
}  // namespace romano::test::shared_address_test
