// Firmware that knows one fixed broker address: every broker serves it in its own cell.

#include <gmock/gmock.h>

#include <algorithm>

#include "tests/overlay/member/brokers.h"

namespace romano::test::cells_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;

class MemberInCells : public testing::Test {
protected:
    void SetUp() override {
        brokers.serve_one_address_in_every_cell();
        for (const int rank : {1, 2, 3}) brokers.start(rank);
        brokers.run_for(1s);
        rover = &brokers.robot("rover", 1);
        rover->connect(false);
        rover->subscribe("go", Qos::exactly_once);
        station = &brokers.robot("station", 3);
        station->connect();
        brokers.run_for(500ms);
    }
    void drive(int cell) {
        brokers.drive(*rover, cell);
        rover->publish("here", "I am", Qos::at_least_once);
        brokers.run_for(1s);
    }
    void tell(const std::string& text) {
        station->publish("go", text, Qos::exactly_once);
        brokers.run_for(1s);
    }

    Brokers brokers;
    Robot* rover = nullptr;
    Robot* station = nullptr;
};

TEST_F(MemberInCells, TheSessionFollowsTheRobot) {
    tell("1");
    drive(2);
    EXPECT_THAT(brokers.sessions_at(2), ElementsAre("rover"));
    tell("2");
    drive(1);
    tell("3");
    EXPECT_THAT(rover->received(), ElementsAre("1", "2", "3"));
    EXPECT_EQ(rover->rejections(), 0);
}

/// The brokers around hear a robot that looks for a nearer one; its home goes on.
TEST_F(MemberInCells, TheSessionStaysWhileTheRobotOnlySearchesOrSpeaksToEverybody) {
    brokers.drive(*rover, 2);
    rover->search();
    rover->publish_without_connection(mqttsn::TopicId{7}, "hello");
    brokers.run_for(500ms);
    brokers.drive(*rover, 1);
    EXPECT_THAT(brokers.sessions_at(1), ElementsAre("rover"));
    EXPECT_THAT(brokers.sessions_at(2), IsEmpty());
    tell("1");
    EXPECT_THAT(rover->received(), ElementsAre("1"));
}

TEST_F(MemberInCells, TheSessionOutlivesItsHomeAndIsFoundInTheNextCell) {
    for (const int next : {2, 3}) {
        brokers.kill(next - 1);
        brokers.run_for(200ms);  // the others have taken over, wherever
        drive(next);
        tell(std::to_string(next));
    }
    EXPECT_THAT(rover->received(), ElementsAre("2", "3"));
    EXPECT_EQ(rover->rejections(), 0);
}

/// However far the others are with the take-over when the robot speaks first.
TEST_F(MemberInCells, TheSessionIsFoundWhileItsHomeIsBeingReplaced) {
    int cell = 1;
    for (int delay = 0; delay <= 120; delay += 8) {
        const int next = cell % 3 + 1;
        brokers.kill(cell);
        brokers.run_for(std::chrono::milliseconds{delay});
        drive(next);
        ASSERT_EQ(rover->rejections(), 0) << delay << " ms after its home's death";
        brokers.start(cell);
        brokers.run_for(2s);
        cell = next;
    }
    tell("1");
    EXPECT_THAT(rover->received(), ElementsAre("1"));
}

TEST_F(MemberInCells, AReturningBrokerTakesNothingFromOtherCells) {
    drive(2);
    brokers.kill(1);
    brokers.run_for(1s);
    brokers.start(1);
    brokers.run_for(3s);
    EXPECT_THAT(brokers.sessions_at(2), ElementsAre("rover"));
    tell("1");
    drive(1);
    tell("2");
    EXPECT_THAT(brokers.sessions_at(1), Contains("rover"));
    EXPECT_THAT(brokers.sessions_at(2), Not(Contains("rover")));
    EXPECT_THAT(rover->received(), ElementsAre("1", "2"));
    EXPECT_EQ(rover->rejections(), 0);
}

}  // namespace
}  // namespace romano::test::cells_test
