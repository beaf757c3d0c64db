// What a broker accepts of a robot, through restarts of both.

#include "romano/protection/broker_end.h"

#include <gtest/gtest.h>

#include "tests/romano/protection/cell.h"

namespace romano::protection {
namespace {

TEST(BrokerEnd, OpensWhatItsRobotSealedOnce) {
    Robot robot;
    Broker broker{1};
    const Octets packet = robot.seal();
    Octets datagram = packet;
    EXPECT_EQ(hex(broker.end.open(datagram)), "0216");
    EXPECT_FALSE(broker.takes(packet));
    EXPECT_EQ(broker.refused(Refusal::replayed), 1u);
}

TEST(BrokerEnd, ItsOwnPacketComesBackInVain) {
    Robot robot;
    Broker broker{1};
    Broker other{2};
    ASSERT_TRUE(broker.takes(robot.seal()));
    Octets packet = broker.seal();
    EXPECT_FALSE(broker.takes(packet));
    EXPECT_FALSE(other.takes(packet));
    EXPECT_EQ(broker.refused(Refusal::unknown_sender), 1u);
    // Also with the robot's name on it: the key is that of the other direction.
    std::ranges::copy(sender_id(robots_name), packet.begin() + 4);
    EXPECT_FALSE(broker.takes(packet));
    EXPECT_FALSE(other.takes(packet));
    EXPECT_EQ(other.refused(Refusal::bad_tag), 1u);
}

TEST(BrokerEnd, SaysNothingToARobotThatItNeverHeard) {
    Broker broker{1};
    EXPECT_TRUE(broker.seal().empty());
    EXPECT_EQ(broker.refused(Refusal::robot_unheard), 1u);
}

TEST(BrokerEnd, AnOvertakenPacketDoesNotBringTheRunBeforeBack) {
    Robot robot;
    const Octets hello = robot.seal();
    Broker broker{1};
    broker.takes(hello);
    const Octets late = robot.seal();
    for (std::uint8_t i = 0; i <= RobotEnd::brokers; ++i) {  // one is forgotten: a new run
        Broker other{static_cast<std::uint8_t>(10 + i)};
        other.takes(hello);
        ASSERT_TRUE(robot.takes(other.seal()));
    }
    ASSERT_TRUE(broker.takes(robot.seal()));
    ASSERT_TRUE(broker.takes(late));
    EXPECT_TRUE(robot.takes(broker.seal()));
}

TEST(BrokerEnd, AfterACrashNothingOfBeforeIsTaken) {
    Robot robot;
    Broker broker{1};
    std::vector<Octets> recorded;
    for (int i = 0; i < 50; ++i) {
        recorded.push_back(robot.seal());
        ASSERT_TRUE(broker.takes(recorded.back()));
    }
    ASSERT_EQ(broker.end.to_store(), std::nullopt);
    const Heard stored{RunId{0}, numbers_a_block};  // what its shell was asked to store
    Broker restarted{1, 2 * numbers_a_block, stored};
    for (const Octets& packet : recorded) EXPECT_FALSE(restarted.takes(packet));
    EXPECT_FALSE(restarted.takes(robot.seal()));  // the rest of the block is lost
    robot.end.skip_block();                       // as before a CONNECT
    EXPECT_TRUE(restarted.takes(robot.seal()));
    EXPECT_TRUE(robot.takes(restarted.seal()));
}

TEST(BrokerEnd, AfterAnOrderlyEndTheRobotsNextPacketIsTaken) {
    Robot robot;
    Broker broker{1};
    const Octets recorded = robot.seal();
    broker.takes(recorded);
    Broker restarted{1, 2 * numbers_a_block, broker.end.heard()};
    EXPECT_FALSE(restarted.takes(recorded));
    EXPECT_TRUE(restarted.takes(robot.seal()));
}

TEST(BrokerEnd, AsksToStoreOncePerBlockAndRun) {
    Robot robot;
    Broker broker{1};
    int stores = 0;
    for (std::uint32_t i = 0; i < 2 * numbers_a_block; ++i) {
        Octets packet = robot.seal();
        ASSERT_FALSE(broker.end.open(packet).empty());
        if (const auto heard = broker.end.to_store()) {
            broker.end.on_stored(*heard);
            ++stores;
        }
    }
    EXPECT_EQ(stores, 2);
    Robot restarted{4 * numbers_a_block};
    Octets packet = restarted.seal();
    broker.end.open(packet);
    EXPECT_EQ(broker.end.to_store(), (Heard{RunId{4 * numbers_a_block}, 5 * numbers_a_block}));
}

TEST(BrokerEnd, ASuccessorTakesNothingFromBeforeTheFirstPacketThatItTakes) {
    Robot robot;
    Broker former{1};
    ASSERT_TRUE(former.takes(robot.seal()));
    const Heard told = *former.end.heard();
    const Octets untold = robot.seal();  // the former broker took it, and died before it told
    ASSERT_TRUE(former.takes(untold));
    Broker successor{2, 0, told};
    EXPECT_TRUE(successor.takes(robot.seal()));
    EXPECT_FALSE(successor.takes(untold));
    EXPECT_EQ(successor.refused(Refusal::replayed), 1u);
    const Octets overtaken = robot.seal();
    EXPECT_TRUE(successor.takes(robot.seal()));
    EXPECT_TRUE(successor.takes(overtaken)) << "later ones may overtake each other as ever";
}

TEST(BrokerEnd, ARobotSpeaksForItselfAlone) {  // a forwarder's encapsulation around a PINGREQ
    Robot robot;
    Broker broker{1};
    EXPECT_FALSE(broker.takes(robot.seal(octets("04fe00aa0216"))));
    EXPECT_EQ(broker.refused(Refusal::forwarded), 1u);
}

TEST(BrokerEnd, APacketHasNoNumberFromTheLastBlock) {  // a window that wraps would forget all
    Robot robot;
    Broker broker{1};
    const Octets recorded = robot.seal();
    ASSERT_TRUE(broker.takes(recorded));
    for (const std::uint32_t number : {max_number, 0xFFFFFFFFU}) {
        Octets packet(40);
        packet.resize(write({sender_id(robots_name), RunId{0}, number}, pingreq,
                            robots_keys.to_broker, packet));
        EXPECT_FALSE(broker.takes(packet));
    }
    EXPECT_EQ(broker.refused(Refusal::malformed), 2u);
    EXPECT_FALSE(broker.takes(recorded));
}

TEST(BrokerEnd, AnotherRobotsKeyOpensNothing) {
    Broker broker{1};
    RobotEnd thief{another_robots_keys, robots_name, 0};  // its own key, another's name
    thief.reserve().on_stored(*thief.reserve().to_store());
    Octets packet(40);
    packet.resize(thief.seal(pingreq, packet));
    EXPECT_FALSE(broker.takes(packet));
    EXPECT_EQ(broker.refused(Refusal::bad_tag), 1u);

    RobotEnd other{another_robots_keys, "ffff0000", 0};
    other.reserve().on_stored(*other.reserve().to_store());
    packet.resize(40);
    packet.resize(other.seal(pingreq, packet));
    EXPECT_FALSE(broker.takes(packet));
    EXPECT_EQ(broker.refused(Refusal::unknown_sender), 1u);
}

}  // namespace
}  // namespace romano::protection
