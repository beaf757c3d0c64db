#include "overlay/cluster/replication/slow_receivers.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::slow_receivers_test {
namespace {

using namespace std::chrono_literals;
using broker::LogEvent;
using mqttsn::Qos;

const LogId peer = test::log_of("peer");
const LogId publisher = test::log_of("publisher");
constexpr std::size_t many = 3;

/// "slow" at the peer subscribed to "pose/+" at QoS 1 and to "map" at QoS 0.
struct SlowReceiversTest : testing::Test {
    SlowReceiversTest() {
        happens(test::session("slow"));
        subscribes("pose/+", Qos::at_least_once);
        subscribes("map", Qos::at_most_once);
    }
    void happens(const LogEvent& event) {
        receivers.on_event(now, mirror, event, many);
        mirror.apply(mirror.applied() + 1, event);
    }
    void subscribes(const std::string& filter, Qos granted) {
        happens(broker::Subscribed{"slow", {.filter = filter, .granted = granted}});
    }
    /// Another message waits for it.
    void comes() {
        const LogPosition position{publisher, ++last};
        happens(broker::Routed{position, {{"slow", Qos::at_least_once}}});
    }
    void is_sent() {
        happens(broker::DeliveryStarted{"slow", {publisher, done + 1}, mqttsn::MsgId{1}, {}});
    }
    void is_taken() { happens(broker::DeliveryEnded{"slow", {publisher, ++done}}); }
    /// The first is on its way to it, as many again as are slow are behind it.
    void falls_behind() {
        comes();
        is_sent();
        for (std::size_t n = 0; n <= many; ++n) comes();
    }
    [[nodiscard]] std::size_t longest(std::string_view topic = "pose/a") const {
        return receivers.longest_queue(topic, now - 10s);
    }

    Instant now = Instant{} + 1min;
    broker::Mirror mirror{peer};
    SlowReceivers receivers;
    broker::Seq last = 0;
    broker::Seq done = 0;
};

TEST_F(SlowReceiversTest, OneWithManyMessagesWaitingIsSlowUntilItHasFewer) {
    comes();
    is_sent();
    for (std::size_t n = 0; n < many; ++n) comes();
    EXPECT_EQ(longest(), 0U);
    comes();
    EXPECT_GT(longest(), many);
    for (int n = 0; n < 3; ++n) {
        is_taken();
        is_sent();
    }
    EXPECT_EQ(longest(), 0U);
}

TEST_F(SlowReceiversTest, OnlyThoseOfTheTopicAtQos1Or2Count) {
    falls_behind();
    EXPECT_GT(longest("pose/b"), many);
    EXPECT_EQ(longest("pose"), 0U);
    EXPECT_EQ(longest("map"), 0U) << "QoS 0 waits nowhere";
}

TEST_F(SlowReceiversTest, OneThatTookNothingForLongHoldsUpNobodyUntilItTakesSomething) {
    falls_behind();
    now += 11s;
    comes();
    EXPECT_EQ(longest(), 0U);
    is_taken();
    is_sent();
    EXPECT_GT(longest(), many);
}

TEST_F(SlowReceiversTest, OneThatWasSentNothingYetHoldsUpNobody) {  // a sleeper, or an owner's own
    for (std::size_t n = 0; n <= 2 * many; ++n) comes();
    EXPECT_EQ(longest(), 0U);
}

TEST_F(SlowReceiversTest, OneThatTakesOtherTopicsWhileTheFirstIsHeldUpCounts) {
    comes();  // its REGISTER was answered with "congestion"
    comes();
    happens(broker::DeliveryStarted{"slow", {publisher, 2}, mqttsn::MsgId{1}, {}});
    for (std::size_t n = 0; n <= many; ++n) comes();
    EXPECT_GT(longest(), many);
    happens(broker::DeliveryEnded{"slow", {publisher, 2}});
    comes();
    EXPECT_EQ(longest(), 0U) << "nothing is on its way";
}

TEST_F(SlowReceiversTest, WhatItSubscribesToLaterCounts) {
    falls_behind();
    subscribes("map", Qos::at_least_once);
    comes();
    EXPECT_GT(longest("map"), many);
    happens(test::unsubscribed("slow", "pose/+"));
    comes();
    EXPECT_EQ(longest("pose/a"), 0U);
}

TEST_F(SlowReceiversTest, OneThatIsGoneHoldsUpNobody) {
    falls_behind();
    happens(test::erased("slow"));
    EXPECT_EQ(longest(), 0U);
}

TEST_F(SlowReceiversTest, OneThatFellAsleepHoldsUpNobody) {
    falls_behind();
    broker::SessionChanged changed{};
    changed.header = mirror.session("slow")->header;
    changed.header.address.endpoint.port = 2;  // it speaks from there now
    happens(changed);
    EXPECT_GT(longest(), many);
    changed.header.state = broker::SessionState::asleep;
    happens(changed);
    EXPECT_EQ(longest(), 0U);
}

TEST_F(SlowReceiversTest, ThoseOfAPeerThatIsUnknownHoldUpNobody) {
    falls_behind();
    receivers.forget(test::log_of("another").broker);
    EXPECT_GT(longest(), many);
    receivers.forget(peer.broker);
    EXPECT_EQ(longest(), 0U);
}

/// "slow" moves to another home as it is.
struct SlowReceiverThatMoves : SlowReceiversTest {
    SlowReceiverThatMoves() { falls_behind(); }
    void moves() {
        receivers.on_event(now, heir, broker::SessionPut{*mirror.session("slow")}, many);
        heir.apply(heir.applied() + 1, broker::SessionPut{*mirror.session("slow")});
    }
    broker::Mirror heir{test::log_of("heir")};
};

TEST_F(SlowReceiverThatMoves, HoldsUpItsPublishersMeanwhile) {
    now += 8s;
    moves();
    EXPECT_GT(longest(), many);
    happens(test::erased("slow"));
    EXPECT_GT(longest(), many) << "its former home lets go of it";
    now += 3s;
    EXPECT_EQ(longest(), 0U) << "that is no proof that it takes anything";
}

TEST_F(SlowReceiverThatMoves, IsKnownAtOnceToWhoDidNotKnowIt) {
    receivers.forget("slow");
    moves();
    EXPECT_GT(longest(), many);
}

TEST_F(SlowReceiverThatMoves, HoldsUpNobodyWhereItHasFewMessagesWaiting) {
    moves();
    broker::SessionPut put{*heir.session("slow")};
    put.image.deliveries.resize(many);
    receivers.on_event(now, heir, put, many);
    EXPECT_EQ(longest(), 0U);
}

TEST_F(SlowReceiverThatMoves, CountsAtTheOldHomeWhenThatGoesOn) {
    moves();
    receivers.forget(heir.log().broker);
    comes();
    EXPECT_GT(longest(), many);
}

TEST_F(SlowReceiversTest, OneThatTakesMessagesFindsRoomAmongManyThatDoNot) {
    falls_behind();
    const broker::SessionImage slow = *mirror.session("slow");
    now += 1s;
    for (std::size_t n = 0; n < SlowReceivers::most_heeded; ++n) {
        broker::SessionPut put{slow};
        put.image.header.client_id = "silent" + std::to_string(n);
        put.image.subscriptions = {{.filter = "map", .granted = Qos::at_least_once}};
        happens(put);
    }
    EXPECT_EQ(longest(), 0U);
    now += 1s;
    comes();
    EXPECT_GT(longest(), many);
}

}  // namespace
}  // namespace romano::cluster::slow_receivers_test
