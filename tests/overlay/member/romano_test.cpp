// The ROMANO server in every broker of a cluster, as robots see it.

#include <gmock/gmock.h>

#include <array>

#include "overlay/member/member.h"
#include "romano/message/codec.h"
#include "romano/server/node_entry.h"
#include "tests/overlay/member/brokers.h"

namespace romano::test::romano_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::MsgType;
using mqttsn::Qos;
using testing::ElementsAre;
using testing::IsEmpty;

std::string encoded(const message::Message& message) {
    std::array<std::uint8_t, message::max_message> octets{};
    const std::size_t size = message::encode(message, octets);
    return std::string{as_text(Bytes{octets}.first(size))};
}

message::RomanoId id(const std::string& text) {
    return *message::RomanoId::parse(text);
}

const std::string ack = encoded(message::ConnectionAck{});

class MemberWithRomano : public testing::Test {
protected:
    void start(std::initializer_list<int> ranks) {
        for (const int rank : ranks) brokers.start(rank);
        brokers.run_for(1s);
    }
    /// Connected and subscribed to its own topic: what comes before the connection request.
    Robot& node(const std::string& name, int broker, bool clean = true) {
        Robot& robot = brokers.robot(name, broker);
        robot.connect(clean);
        robot.subscribe(name, Qos::exactly_once);
        brokers.run_for(200ms);
        return robot;
    }
    static void request(Robot& robot, const std::string& name, Qos qos = Qos::at_least_once) {
        robot.publish("init-info", encoded(message::ConnectionRequest{id(name)}), qos);
    }
    Robot& established(const std::string& name, int broker, bool clean = true) {
        Robot& robot = node(name, broker, clean);
        request(robot, name);
        brokers.run_for(200ms);
        return robot;
    }
    void beat(Robot& robot, const std::string& name, int times) {
        for (int i = 0; i < times; ++i) {
            robot.publish("common", encoded(message::Heartbeat{id(name)}), Qos::at_most_once);
            brokers.run_for(1s);
        }
    }
    /// What broker `rank` knows of the node.
    [[nodiscard]] std::optional<server::NodeEntry> entry(int rank, const std::string& name) const {
        const auto found = brokers.member(rank).broker().retained(server::entry_topic(id(name)));
        if (found.empty()) return std::nullopt;
        return server::parse_entry(found[0]->topic, as_text(found[0]->payload));
    }

    Brokers brokers;
};

TEST_F(MemberWithRomano, TheHomeAloneAcknowledgesAndEveryBrokerKnowsTheNode) {
    start({1, 2, 3});
    Robot& robot = established("abcd1234", 1);
    EXPECT_THAT(robot.received(), ElementsAre(ack));
    for (const int rank : {1, 2, 3}) {
        ASSERT_TRUE(entry(rank, "abcd1234")) << rank;
        EXPECT_EQ(entry(rank, "abcd1234")->home, "b1");
    }
}

TEST_F(MemberWithRomano, AnyBrokerListsTheNodesOfAll) {
    start({1, 2, 3});
    established("00000001", 1);
    established("00000002", 2);
    Robot& asker = established("00000003", 3);
    asker.publish("init-info", encoded(message::RequestConnectedNodes{id("00000003")}),
                  Qos::at_least_once);
    brokers.run_for(200ms);
    EXPECT_THAT(
        asker.received(),
        ElementsAre(ack, encoded(message::ConnectedNodes{as_octets("000000010000000200000003")})));
}

TEST_F(MemberWithRomano, ANodeThatWasInitialisedBeforeItsHomeDiedGoesOn) {
    start({1, 2, 3});
    Robot& robot = established("abcd1234", 1);
    Robot& commander = established("00000002", 2);
    brokers.kill(1);
    commander.publish("abcd1234", "go", Qos::at_least_once);
    brokers.run_for(3s);
    EXPECT_THAT(robot.received(), ElementsAre(ack, "go"));
    EXPECT_EQ(robot.count_sent(MsgType::connect), 1);
    for (const int rank : {2, 3}) EXPECT_NE(entry(rank, "abcd1234").value().home, "b1") << rank;
}

TEST_F(MemberWithRomano, TheHeirAnswersTheRequestThatADeadHomeDidNot) {
    start({1, 2, 3});
    Robot& robot = node("abcd1234", 1);
    brokers.kill(1);
    request(robot, "abcd1234");
    brokers.run_for(3s);
    EXPECT_THAT(robot.received(), ElementsAre(ack));
    ASSERT_TRUE(entry(2, "abcd1234"));
    EXPECT_NE(entry(2, "abcd1234")->home, "b1");
}

TEST_F(MemberWithRomano, ARequestIsAcknowledgedOnceWheneverItsHomeDies) {
    for (int delay = 0; delay < 40; delay += 3) {
        SCOPED_TRACE(delay);
        Brokers many;
        for (const int rank : {1, 2, 3}) many.start(rank);
        many.run_for(1s);
        Robot& robot = many.robot("abcd1234", 1);
        robot.connect();
        robot.subscribe("abcd1234", Qos::exactly_once);
        many.run_for(200ms);
        request(robot, "abcd1234", Qos::exactly_once);
        many.run_for(delay * 1ms);
        many.kill(1);
        many.run_for(4s);
        EXPECT_THAT(robot.received(), ElementsAre(ack));
        EXPECT_EQ(robot.count_sent(MsgType::connect), 1);
    }
}

TEST_F(MemberWithRomano, EntriesAreRightAgainAfterAPartition) {
    start({1, 2, 3});
    established("00000001", 1);
    established("00000003", 3);
    brokers.cut(1, 2);
    brokers.cut(1, 3);
    brokers.run_for(5s);
    EXPECT_EQ(entry(1, "00000001").value().home, "b1");
    EXPECT_NE(entry(3, "00000001").value().home, "b1") << "adopted on the other side";
    brokers.heal();
    brokers.run_for(5s);
    for (const int rank : {1, 2, 3}) {
        EXPECT_EQ(entry(rank, "00000001").value().home, "b1") << rank;
        EXPECT_EQ(entry(rank, "00000003").value().home, "b3") << rank;
    }
}

TEST_F(MemberWithRomano, ANodeThatDisconnectsIsForgottenEverywhere) {
    start({1, 2});
    Robot& robot = established("abcd1234", 1);
    robot.disconnect();
    brokers.run_for(2s);
    EXPECT_FALSE(entry(1, "abcd1234"));
    EXPECT_FALSE(entry(2, "abcd1234"));
}

TEST_F(MemberWithRomano, CommandsWaitForANodeWhoseHeartbeatsAreMissing) {
    start({1, 2});
    Robot& robot = established("abcd1234", 1, false);
    Robot& commander = established("00000002", 2);
    beat(robot, "abcd1234", 4);
    brokers.run_for(5s);
    ASSERT_EQ(entry(2, "abcd1234").value().state, server::NodeState::silent);
    commander.publish("abcd1234", "1", Qos::at_least_once);
    commander.publish("abcd1234", "2", Qos::at_most_once);
    brokers.run_for(2s);
    EXPECT_THAT(robot.received(), ElementsAre(ack));
    beat(robot, "abcd1234", 1);
    EXPECT_THAT(robot.received(), ElementsAre(ack, "1", "2"));
    EXPECT_EQ(entry(2, "abcd1234").value().state, server::NodeState::connected);
}

TEST_F(MemberWithRomano, CommandsThatWaitOutliveTheHome) {
    start({1, 2, 3});
    Robot& robot = established("abcd1234", 1, false);
    Robot& commander = established("00000002", 2);
    beat(robot, "abcd1234", 4);
    brokers.run_for(5s);
    commander.publish("abcd1234", "1", Qos::exactly_once);
    brokers.run_for(1s);
    brokers.kill(1);
    brokers.run_for(3s);
    EXPECT_THAT(entry(3, "abcd1234").value().state, server::NodeState::silent);
    commander.publish("abcd1234", "2", Qos::exactly_once);
    brokers.run_for(1s);
    beat(robot, "abcd1234", 2);
    EXPECT_THAT(robot.received(), ElementsAre(ack, "1", "2"));
}

}  // namespace
}  // namespace romano::test::romano_test
