#include "overlay/cluster/replication/log_sender.h"

#include <gtest/gtest.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::log_sender_test {
namespace {

using namespace std::chrono_literals;

const LogId self = test::log_of("self");
const LogId peer = test::log_of("peer");

struct LogSenderTest : testing::Test {
    LogSenderTest() {
        for (Seq seq = 1; seq <= 1'000; ++seq) own.append(seq, test::published(self, seq));
        hear(peer);
        act([this](Effects& acting) {
            sender.on_fetch(acting, {{self, 0}, peer.broker}, logs, membership, departures);
        });
    }
    [[nodiscard]] bool is_sending() const { return sender.next_wakeup() != Instant::max(); }

    void hear(const LogId& log) {
        Beacon beacon{.name = "peer", .log = log};
        membership.on_beacon(now, beacon);
    }
    template <typename Act>
    Outbox act(Act&& act_on) {
        Outbox out;
        std::vector<LocalAction> local;
        broker::Actions clients;
        Effects effects{now, core, clients, out, local, test::times};
        act_on(effects);
        return out;
    }
    /// The parts that leave at this moment.
    std::size_t carry_on() {
        const Outbox out =
            act([this](Effects& acting) { sender.carry_on(acting, logs, membership, departures); });
        for (const auto& outgoing : out) EXPECT_EQ(outgoing.to, peer.broker);
        return out.size();
    }

    Instant now{10s};
    broker::BrokerCore core{test::writer_of(self), 1};
    PeerLogs peers;
    OwnLog own{self, 1'000};
    Logs logs{peers, own};
    Departures departures{256};
    Membership membership{ClusterOptions{}, self.broker, 1};
    LogSender sender;
};

TEST_F(LogSenderTest, SomePartsLeaveAtATime) {
    std::size_t sent = 0;
    for (; is_sending(); now = std::max(now, sender.next_wakeup())) {
        const std::size_t parts = carry_on();
        ASSERT_GE(parts, 1U);
        ASSERT_LE(parts, 3U);
        EXPECT_EQ(carry_on(), 0U) << "not before it is time";
        sent += parts;
    }
    EXPECT_EQ(sent, 16U) << "1,000 publishes, 64 a part";
    EXPECT_EQ(sender.next_wakeup(), Instant::max());
}

TEST_F(LogSenderTest, WhatIsForAnEarlierLifeOfThePeerIsDropped) {
    carry_on();
    EXPECT_TRUE(is_sending());
    now += 2ms;
    hear(test::log_of("peer", 2));
    EXPECT_EQ(carry_on(), 0U);
    EXPECT_FALSE(is_sending());
}

}  // namespace
}  // namespace romano::cluster::log_sender_test
