// What a robot accepts, of whichever broker.

#include "romano/protection/robot_end.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "tests/romano/protection/cell.h"

namespace romano::protection {
namespace {

TEST(RobotEnd, OpensWhatItsBrokerSealed) {
    Robot robot;
    Broker broker{1};
    ASSERT_TRUE(broker.takes(robot.seal()));
    Octets packet = broker.seal(octets("0617aabbccdd"));
    const Bytes message = robot.end.open(packet);
    EXPECT_EQ(hex(message), "0617aabbccdd");
}

TEST(RobotEnd, TakesAPacketOnce) {
    Robot robot;
    Broker broker{1};
    broker.takes(robot.seal());
    const Octets packet = broker.seal();
    EXPECT_TRUE(robot.takes(packet));
    EXPECT_FALSE(robot.takes(packet));
    EXPECT_EQ(robot.refused(Refusal::replayed), 1u);
}

TEST(RobotEnd, TakesLatePacketsOnceEach) {
    Robot robot;
    Broker broker{1};
    broker.takes(robot.seal());
    std::vector<Octets> packets(ReplayWindow::width + 1);
    for (Octets& packet : packets) packet = broker.seal();
    for (auto packet = packets.rbegin(); packet + 1 != packets.rend(); ++packet) {
        EXPECT_TRUE(robot.takes(*packet));
        EXPECT_FALSE(robot.takes(*packet));
    }
    EXPECT_FALSE(robot.takes(packets.front()));  // too old to tell
}

TEST(RobotEnd, ItsOwnPacketComesBackInVain) {
    Robot robot;
    EXPECT_FALSE(robot.takes(robot.seal()));
    EXPECT_EQ(robot.refused(Refusal::bad_tag), 1u);  // the key is that of the other direction
}

TEST(RobotEnd, TwoBrokersSpeakToItAtOnce) {  // a partition
    Robot robot;
    Broker one{1};
    Broker other{2};
    const Octets hello = robot.seal();
    ASSERT_TRUE(one.takes(hello));
    ASSERT_TRUE(other.takes(hello));
    for (int i = 0; i < 100; ++i) {
        EXPECT_TRUE(robot.takes(one.seal()));
        EXPECT_TRUE(robot.takes(other.seal()));
    }
}

TEST(RobotEnd, ASuccessorThatNeverHeardItIsHeardAtOnce) {
    Robot robot;
    Broker home{1};
    home.takes(robot.seal());
    Broker successor{2, 0, home.end.heard()};
    EXPECT_TRUE(robot.takes(successor.seal()));
}

TEST(RobotEnd, NothingOfBeforeItsRestartIsTaken) {
    Robot robot;
    Broker broker{1};
    broker.takes(robot.seal());
    const Octets never_arrived = broker.seal();
    Robot restarted{2 * numbers_a_block};
    EXPECT_FALSE(restarted.takes(never_arrived));
    EXPECT_EQ(restarted.refused(Refusal::other_run), 1u);
    broker.takes(restarted.seal());
    EXPECT_FALSE(restarted.takes(never_arrived));
    EXPECT_TRUE(restarted.takes(broker.seal()));
}

TEST(RobotEnd, ABrokerThatIsForgottenCannotBePlayedBack) {
    Robot robot;
    std::vector<std::unique_ptr<Broker>> brokers;
    const Octets hello = robot.seal();
    for (std::uint8_t i = 0; i <= RobotEnd::brokers; ++i) {
        brokers.push_back(std::make_unique<Broker>(i));
        brokers.back()->takes(hello);
    }
    std::vector<Octets> recorded;
    for (auto& broker : brokers) {
        recorded.push_back(broker->seal());
        EXPECT_TRUE(robot.takes(recorded.back()));
    }
    for (const Octets& packet : recorded) EXPECT_FALSE(robot.takes(packet));
    // The others are heard again when they have heard the robot.
    EXPECT_FALSE(robot.takes(brokers.back()->seal()));
    EXPECT_EQ(robot.refused(Refusal::other_run), RobotEnd::brokers + 2);
    brokers.back()->takes(robot.seal());
    EXPECT_TRUE(robot.takes(brokers.back()->seal()));
}

TEST(RobotEnd, WithAsManyBrokersAsItRemembersNoneIsForgotten) {
    Robot robot;
    std::vector<std::unique_ptr<Broker>> brokers;
    const Octets hello = robot.seal();
    for (std::uint8_t i = 0; i < RobotEnd::brokers; ++i) {
        brokers.push_back(std::make_unique<Broker>(i));
        brokers.back()->takes(hello);
    }
    for (int i = 0; i < 10; ++i) {
        for (auto& broker : brokers) EXPECT_TRUE(robot.takes(broker->seal()));
    }
}

TEST(RobotEnd, AnotherRobotsPacketsAreNotForIt) {
    Robot robot;
    Reserve reserve{0};
    reserve.on_stored(*reserve.to_store());
    BrokerEnd of_another{another_robots_keys, robots_name, counting_array<8>(1), reserve,
                         Heard{RunId{0}, 0}};
    Octets packet(40);
    packet.resize(of_another.seal(pingresp, packet));
    ASSERT_FALSE(packet.empty());
    EXPECT_FALSE(robot.takes(packet));
    EXPECT_EQ(robot.refused(Refusal::bad_tag), 1u);
}

TEST(RobotEnd, RefusalsOfItsOwnPacketsAreCounted) {
    RobotEnd end{robots_keys, robots_name, 0};
    Octets room(40);
    EXPECT_EQ(end.seal(pingreq, room), 0u);
    EXPECT_EQ(end.refusals().of(Refusal::unstored), 1u);
    end.reserve().on_stored(*end.reserve().to_store());
    EXPECT_EQ(end.seal(Octets(100), room), 0u);
    EXPECT_EQ(end.refusals().of(Refusal::too_long), 1u);
}

}  // namespace
}  // namespace romano::protection
