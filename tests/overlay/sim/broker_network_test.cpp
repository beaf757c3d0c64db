#include "overlay/sim/broker_network.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace romano::sim::broker_network_test {
namespace {

using namespace std::chrono_literals;
using broker::BrokerId;
using broker::LogId;

class BrokerNetworkTest : public testing::Test {
protected:
    struct Process {
        LogId id;
        std::unique_ptr<overlay::Transport> port;
        std::vector<broker::Seq> log;        // LogBatch by first_seq
        std::vector<std::uint64_t> beacons;  // by tick
    };

    void start(Process& process, std::uint64_t number) {
        process.id = {BrokerId{number}, 1};
        process.port = network.attach(process.id, Node{static_cast<std::uint32_t>(number)});
        process.port->start([&process](const overlay::Envelope& envelope) {
            if (const auto* batch = std::get_if<cluster::LogBatch>(&envelope.message)) {
                process.log.push_back(batch->first_seq);
            } else if (const auto* beacon = std::get_if<cluster::Heartbeat>(&envelope.message)) {
                process.beacons.push_back(beacon->tick);
            }
        });
    }
    void start_all() {
        start(a, 1);
        start(b, 2);
        start(c, 3);
        events.run_for(100ms);  // matched
    }
    void log(broker::Seq seq) { a.port->send({std::nullopt, cluster::LogBatch{a.id, seq, {}}}); }
    void beacon(std::uint64_t tick) {
        cluster::Heartbeat message;
        message.tick = tick;
        a.port->send({std::nullopt, message});
    }

    EventQueue events;
    Trace trace;
    BrokerNetwork network{events, trace, {}, 1};
    Process a, b, c;
};

using Seqs = std::vector<broker::Seq>;

TEST_F(BrokerNetworkTest, ReliableMessagesComeToAllInOrderDespiteLoss) {
    start_all();
    network.set_quality({.delay_max = 10ms, .loss_ppm = 300'000});
    Seqs sent;
    for (broker::Seq seq = 1; seq <= 100; ++seq) {
        sent.push_back(seq);
        log(seq);
        events.run_for(1ms);
    }
    events.run_for(1s);
    EXPECT_EQ(b.log, sent);
    EXPECT_EQ(c.log, sent);
}

TEST_F(BrokerNetworkTest, NothingPassesBeforeTwoProcessesMatch) {
    start(a, 1);
    start(b, 2);
    log(1);
    events.run_for(100ms);
    log(2);
    events.run_for(100ms);
    EXPECT_EQ(b.log, Seqs{2});
}

TEST_F(BrokerNetworkTest, AnOlderBeaconNeverComesBehindANewerOne) {
    start_all();
    network.set_quality({.delay_min = 0ms, .delay_max = 20ms});
    for (std::uint64_t tick = 1; tick <= 200; ++tick) {
        beacon(tick);
        events.run_for(1ms);
    }
    events.run_for(1s);
    EXPECT_LT(b.beacons.size(), 200U);
    EXPECT_TRUE(std::ranges::is_sorted(b.beacons));
}

TEST_F(BrokerNetworkTest, ACutHoldsReliableMessagesUpAndLosesBeacons) {
    start_all();
    network.cut(Node{1}, Node{2});
    log(1);
    beacon(1);
    events.run_for(900ms);  // within the lease
    EXPECT_EQ(b.log, Seqs{});
    EXPECT_EQ(c.log, Seqs{1});
    network.join(Node{1}, Node{2});
    events.run_for(1s);
    EXPECT_EQ(b.log, Seqs{1});
    EXPECT_TRUE(b.beacons.empty());
}

TEST_F(BrokerNetworkTest, ACutLongerThanTheLeaseLosesWhatItHeldUp) {
    start_all();
    network.cut(Node{1}, Node{2});
    log(1);
    events.run_for(2s);
    network.join(Node{1}, Node{2});
    events.run_for(200ms);  // they match again
    log(2);
    events.run_for(1s);
    EXPECT_EQ(b.log, Seqs{2});
    EXPECT_EQ(c.log, (Seqs{1, 2}));
}

TEST_F(BrokerNetworkTest, ADeadSendersStreamEndsAtTheFirstLostMessage) {
    start_all();
    network.set_quality({.loss_ppm = 50'000});
    for (broker::Seq seq = 1; seq <= 50; ++seq) log(seq);
    a.port.reset();
    events.run_for(1s);
    EXPECT_LT(b.log.size(), 50U);
    EXPECT_NE(b.log.size(), c.log.size());
    for (std::size_t i = 0; i < b.log.size(); ++i) EXPECT_EQ(b.log[i], i + 1);
}

TEST_F(BrokerNetworkTest, AStoppedProcessGetsItsReliableMessagesLater) {
    start_all();
    network.stall(Node{2});
    log(1);
    events.run_for(900ms);  // within the lease
    EXPECT_EQ(b.log, Seqs{});
    network.go_on(Node{2});
    events.run_for(1s);
    EXPECT_EQ(b.log, Seqs{1});
}

// --- a backbone

/// Keeps what it is given.
class Slow : public Backbone {
public:
    void send(Node, std::optional<Node>, std::size_t, Arrived arrived, Left left) override {
        waiting.push_back({std::move(arrived), std::move(left)});
    }
    [[nodiscard]] bool reaches(Node, Node) const override { return true; }

    struct Datagram {
        Arrived arrived;
        Left left;
    };
    std::vector<Datagram> waiting;
};

class OnABackbone : public BrokerNetworkTest {
protected:
    OnABackbone() {
        network.set_backbone(&backbone);
        start(a, 1);
        start(b, 2);
        events.run_for(200ms);  // matched
    }
    Slow backbone;
};

// Else a sender whose queue is full would fill it with copies of what waits there.
TEST_F(OnABackbone, AMessageIsRepeatedSomeTimeAfterItsLastCopyHasLeft) {
    log(1);
    events.run_for(10s);
    EXPECT_EQ(backbone.waiting.size(), 1U);
    backbone.waiting[0].left();
    events.run_for(19ms);
    EXPECT_EQ(backbone.waiting.size(), 1U);
    events.run_for(2ms);
    ASSERT_EQ(backbone.waiting.size(), 2U);
    events.run_for(10s);
    EXPECT_EQ(backbone.waiting.size(), 2U);
    backbone.waiting[1].left();
    events.run_for(41ms);
    EXPECT_EQ(backbone.waiting.size(), 3U);
}

// However long the one before it was on its way.
TEST_F(OnABackbone, TheNextLostMessageIsRepeatedAsSoonAsTheOneBeforeItHasCome) {
    log(1);
    log(2);
    for (const auto& datagram : std::vector{backbone.waiting}) datagram.left();
    events.run_for(10s);  // only the oldest is sent again
    ASSERT_EQ(backbone.waiting.size(), 3U);
    backbone.waiting[2].arrived(Node{2});
    ASSERT_EQ(b.log, Seqs{1});
    events.run_for(21ms);
    ASSERT_EQ(backbone.waiting.size(), 5U);  // behind the answer to the first one
    backbone.waiting[4].arrived(Node{2});
    EXPECT_EQ(b.log, (Seqs{1, 2}));
}

}  // namespace
}  // namespace romano::sim::broker_network_test
