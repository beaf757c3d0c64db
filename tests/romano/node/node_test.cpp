// The ROMANO node on a real broker core: the establishment phase, and what a robot does on command.
#include "romano/node/node.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/romano/node/cell.h"

namespace romano::node::node_test {
namespace {

using namespace std::chrono_literals;
using message::RomanoId;
using mqttsn::Qos;
using Texts = std::vector<std::pair<std::string, std::string>>;

/// A robot: client, node, mailbox, and what its application saw.
class Robot final : public Station, public Port {
public:
    Robot(Cell& cell, std::string_view id, std::uint16_t port, NodeOptions options = {})
        : Station(port), cell_(cell) {
        options.id = *RomanoId::parse(id);
        node_ = std::make_unique<Node>(client_, scratch_, mailbox, options);
        cell.join(*this);
    }
    void start() {
        node_->start(cell_.now(), *this);
        cell_.settle();
    }
    void on_datagram(Instant now, Bytes datagram) override {
        if (!away) node_->on_datagram(now, datagram, *this);
    }
    void on_tick(Instant now) override {
        if (!away && node_->next_wakeup() <= now) node_->on_tick(now, *this);
    }
    void send(Bytes datagram) override {
        if (!dumb) cell_.from_station(*this, datagram);
    }
    void on_established() override { ++established; }
    void on_publish_request(std::string_view topic, Bytes kind) override {
        requests.emplace_back(std::string{topic}, std::string{as_text(kind)});
    }
    void on_message(std::string_view topic, Bytes octets) override {
        const auto message = message::decode(octets);
        ASSERT_TRUE(message);
        if (const auto* data = std::get_if<message::NormalData>(&*message)) {
            data_received.emplace_back(std::string{topic}, std::string{as_text(data->data)});
        } else if (std::holds_alternative<message::Heartbeat>(*message)) {
            ++heartbeats;
        }
    }
    Node& node() { return *node_; }
    void publish(std::string_view topic, const message::Message& message,
                 Qos qos = Qos::at_least_once) {
        ASSERT_TRUE(node_->publish(cell_.now(), topic, message, qos, *this));
        cell_.settle();
    }
    std::uint32_t next_amount() {
        romano_command command{};
        return romano_mailbox_get(&mailbox, &command) ? romano_command_amount(&command) : 0;
    }

    bool away = false;  // hears nothing, says nothing
    bool dumb = false;  // what it says is lost
    romano_mailbox mailbox{};
    int established = 0;
    int heartbeats = 0;
    Texts requests;
    Texts data_received;

private:
    Cell& cell_;
    client::Client<client::DeviceLimits> client_;
    client::OutputFor<client::DeviceLimits> scratch_;
    std::unique_ptr<Node> node_;
};

/// Answers connection requests on init-info, as a ROMANO server does; publishes what a test wants.
class Server final : public Station {
public:
    explicit Server(Cell& cell) : Station(9), cell_(cell) {
        cell.join(*this);
        client_.connect(cell.now(), {.client_id = "server"}, out_);
        flush();
        (void)client_.subscribe(cell.now(), client::topic_name(init_topic), Qos::at_least_once,
                                out_);
        flush();
        cell.settle();
    }
    void publish(std::string_view topic, Bytes data, bool retain = false) {
        (void)client_.publish(cell_.now(), client::topic_name(topic), data,
                              {.qos = Qos::at_least_once, .retain = retain}, out_);
        flush();
    }
    void on_datagram(Instant now, Bytes datagram) override {
        client_.on_datagram(now, datagram, out_);
        std::vector<RomanoId> asking;
        for (const auto& event : out_.events()) {
            const auto* received = std::get_if<client::Received>(&event);
            if (received == nullptr) continue;
            const auto message = message::decode(received->data);
            if (message && std::holds_alternative<message::ConnectionRequest>(*message)) {
                asking.push_back(std::get<message::ConnectionRequest>(*message).sender);
            }
        }
        flush();
        for (const RomanoId& id : asking) {
            ++requests;
            const std::vector<std::uint8_t> ack{0x0C, 0x02};
            if (!silent) publish(id.text(), ack);
        }
    }
    void on_tick(Instant now) override {
        client_.on_tick(now, out_);
        flush();
    }
    bool silent = false;
    int requests = 0;

private:
    void flush() {
        for (const Bytes datagram : out_.datagrams()) cell_.from_station(*this, datagram);
    }
    Cell& cell_;
    client::Client<> client_;
    client::OutputFor<> out_;
};

class NodeTest : public testing::Test {
protected:
    Cell cell;
    Server server{cell};
    Robot robot{cell, "abcd1234", 1001};
    Robot other{cell, "0433ed81", 1002};
};

TEST_F(NodeTest, IsEstablishedAfterTheServersAcknowledgement) {
    robot.start();
    EXPECT_EQ(robot.node().phase(), Phase::established);
    EXPECT_EQ(robot.established, 1);
    EXPECT_EQ(server.requests, 1);
}

TEST_F(NodeTest, RepeatsItsConnectionRequestEveryTwoSecondsForEver) {
    server.silent = true;
    robot.start();
    cell.run_for(61s);
    EXPECT_EQ(robot.node().phase(), Phase::requesting);
    EXPECT_NEAR(server.requests, 31, 1);
    server.silent = false;
    cell.run_for(3s);
    EXPECT_EQ(robot.node().phase(), Phase::established);
}

TEST_F(NodeTest, IsReachedAloneByItsIdAndTogetherByCommon) {
    robot.start();
    other.start();
    other.publish("abcd1234", message::NormalData{as_octets("one")});
    other.publish("common", message::NormalData{as_octets("all")});
    EXPECT_EQ(robot.data_received, (Texts{{"abcd1234", "one"}, {"common", "all"}}));
    EXPECT_EQ(other.data_received, (Texts{{"common", "all"}}));
}

TEST_F(NodeTest, PutsMovementsIntoTheMailbox) {
    robot.start();
    other.start();
    const std::vector<std::uint8_t> millimetres{0, 0, 0, 100};
    other.publish("abcd1234", message::MovementControl{message::MovementType::front, millimetres});
    EXPECT_EQ(robot.next_amount(), 100U);
    EXPECT_TRUE(robot.data_received.empty());
}

TEST_F(NodeTest, ARetainedMovementIsOfThePastAndNotCarriedOut) {
    other.start();
    const std::vector<std::uint8_t> front_100mm{0x07, 0x08, 0, 0, 0, 0, 0, 100};
    server.publish("common", front_100mm, true);
    server.publish("abcd1234", front_100mm, true);
    server.publish("0433ed81", std::vector<std::uint8_t>{0x08, 0x03, 'w'}, true);
    cell.settle();
    EXPECT_EQ(other.next_amount(), 100U) << "it was said to robots that were there";
    robot.start();
    EXPECT_EQ(robot.node().phase(), Phase::established);
    EXPECT_EQ(robot.next_amount(), 0U);
    EXPECT_EQ(robot.node().counters().retained_commands, 2U);
    const std::uint32_t before = robot.node().counters().received;
    ASSERT_TRUE(robot.node().subscribe(cell.now(), "0433ed81", robot));
    cell.settle();
    EXPECT_EQ(robot.node().counters().received, before + 1);
    EXPECT_EQ(robot.node().counters().retained_commands, 3U);
}

TEST_F(NodeTest, AMovementAtQos2IsCarriedOutOnceThoughItsAnswerIsLost) {
    robot.start();
    other.start();
    robot.dumb = true;
    const std::vector<std::uint8_t> millimetres{0, 0, 0, 100};
    other.publish("abcd1234", message::MovementControl{message::MovementType::front, millimetres},
                  Qos::exactly_once);
    cell.run_for(15s);  // the broker repeats it
    robot.dumb = false;
    cell.run_for(15s);
    EXPECT_EQ(robot.next_amount(), 100U);
    EXPECT_EQ(robot.next_amount(), 0U);
}

TEST_F(NodeTest, SubscribesAndUnsubscribesOnCommand) {
    robot.start();
    other.start();
    other.publish("abcd1234", message::MqttSubscribe{"line"});
    other.publish("line", message::NormalData{as_octets("a")});
    EXPECT_EQ(robot.data_received.size(), 1U);
    other.publish("abcd1234", message::MqttUnsubscribe{"line"});
    other.publish("line", message::NormalData{as_octets("b")});
    EXPECT_EQ(robot.data_received.size(), 1U);
}

TEST_F(NodeTest, HandsPublishRequestsToTheApplication) {
    robot.start();
    other.start();
    other.publish("abcd1234", message::MqttPublishRequest{"telemetry", as_octets("ir")});
    EXPECT_EQ(robot.requests, (Texts{{"telemetry", "ir"}}));
}

TEST_F(NodeTest, SendsHeartbeatsOnCommonWhenAsked) {
    NodeOptions options;
    options.heartbeat_every = 1s;
    Robot beating{cell, "00000001", 1003, options};
    robot.start();
    beating.start();
    cell.run_for(5s);
    EXPECT_NEAR(robot.heartbeats, 5, 1);
}

TEST_F(NodeTest, DropsAndCountsMalformedMessages) {
    robot.start();
    const std::vector<std::uint8_t> garbage{0x07, 0x55, 0x00};
    server.publish("common", garbage);
    cell.settle();
    EXPECT_EQ(robot.node().counters().malformed, 1U);
    EXPECT_EQ(robot.next_amount(), 0U);
}

TEST_F(NodeTest, WithAKeptSessionItGetsWhatWasSentWhileItWasAway) {
    NodeOptions options;
    options.keep_session = true;
    Robot keeping{cell, "00000001", 1003, options};
    keeping.start();
    other.start();
    keeping.away = true;
    cell.run_for(60s);  // its broker takes it for lost
    other.publish("00000001", message::NormalData{as_octets("one")});
    keeping.away = false;
    cell.run_for(60s);
    EXPECT_EQ(keeping.data_received, (Texts{{"00000001", "one"}}));
    EXPECT_EQ(keeping.established, 2);
}

TEST_F(NodeTest, WhoLeavesSaysSoAndHearsNothingAnyMore) {
    NodeOptions options;
    options.keep_session = true;
    options.heartbeat_every = 1s;
    Robot leaving{cell, "00000001", 1003, options};
    leaving.start();
    other.start();
    leaving.node().leave(cell.now(), leaving);
    EXPECT_FALSE(leaving.node().has_left()) << "the broker has not confirmed it yet";
    cell.settle();
    EXPECT_TRUE(leaving.node().has_left());
    const int heard = other.heartbeats;
    other.publish("00000001", message::NormalData{as_octets("one")});
    cell.run_for(120s);
    EXPECT_EQ(leaving.data_received, Texts{});
    EXPECT_EQ(other.heartbeats, heard);
    EXPECT_EQ(leaving.node().counters().connections_lost, 0U);
    leaving.start();  // the session was kept: it was a goodbye and no loss
    EXPECT_EQ(leaving.data_received, (Texts{{"00000001", "one"}}));
}

TEST_F(NodeTest, WhoLeavesABrokerThatIsDeafEndsAllTheSame) {
    robot.start();
    robot.dumb = true;
    robot.node().leave(cell.now(), robot);
    cell.run_for(10min);
    EXPECT_TRUE(robot.node().has_left());
    EXPECT_EQ(robot.established, 1);
    EXPECT_EQ(robot.node().next_wakeup(), never);
}

TEST_F(NodeTest, ConnectsAgainWhenTheBrokerHasForgottenIt) {
    robot.start();
    cell.replace_broker();
    cell.run_for(40s);  // its keep-alive ping is answered by DISCONNECT
    EXPECT_GE(robot.node().counters().connections_lost, 1U);
    EXPECT_EQ(robot.node().phase(), Phase::requesting) << "the server's subscription is gone too";
}

}  // namespace
}  // namespace romano::node::node_test
