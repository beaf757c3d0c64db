#include "overlay/cluster/replication/publish_order.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::publish_order_test {
namespace {

using namespace std::chrono_literals;

const LogId self = test::log_of("self");
const LogId former = test::log_of("former");
const LogId next = test::log_of("next");
const LogId third = test::log_of("third");

/// A member that applies the logs of two homes, and of a third broker.
class PublishOrderTest : public testing::Test {
protected:
    PublishOrderTest() {
        for (const LogId& log : {former, next, third}) {
            logs.try_emplace(log, log, 1'000).first->second.set_apart(true);
        }
    }

    Effects effects() { return {now, broker, clients, peers, local, test::times}; }
    /// The next event of a log is applied.
    void apply(const LogId& id, const LogEvent& event) {
        PeerLog& log = logs.at(id);
        Effects acting = effects();
        log.offer(log.applied() + 1, {event});
        if (const auto* put = std::get_if<broker::SessionPut>(&event)) {
            order.on_session(acting, log, put->image, logs, view);
        }
        log.apply();
        if (const auto* published = std::get_if<broker::Published>(&event)) {
            order.on_publish(acting, published->message);
        }
        carry_on();
    }
    void publish(const LogId& id) { apply(id, test::published(id, logs.at(id).applied() + 1)); }
    void carry_on() {
        Effects acting = effects();
        order.allow(allowed);
        order.carry_on(acting, logs, view);
    }
    /// What waits of `next` is handed on then, and no sooner.
    void expect_next_after(Duration time, Seq through) {
        now += time - 1ms;
        carry_on();
        EXPECT_EQ(broker.cursor(next), 0U);
        now += 1ms;
        carry_on();
        EXPECT_EQ(broker.cursor(next), through);
    }
    /// A part of a snapshot: publishes at these positions, each published at the time of that
    /// count.
    void part(const LogId& id, const std::vector<Seq>& seqs,
              std::vector<broker::SessionImage> sessions = {}) {
        SnapshotPart part{.as_of = {id, 1'000}, .sessions = std::move(sessions)};
        for (const Seq seq : seqs) {
            broker::Message message =
                *std::get<broker::Published>(test::published(id, seq)).message;
            message.published_at = {seq};
            part.publishes.emplace_back(std::move(message));
        }
        Effects acting = effects();
        order.on_snapshot(acting, part, logs);
    }
    /// The last part.
    void snapshot(const LogId& id, const std::vector<Seq>& publishes, Seq as_of) {
        part(id, publishes);
        PeerLog& log = logs.at(id);
        ASSERT_TRUE(log.offer({.as_of = {id, as_of}, .last = true}));
        ASSERT_TRUE(log.restart());
        Effects acting = effects();
        order.on_snapshot_end(acting, {id, as_of});
        carry_on();
    }
    /// Somebody here gets what the broker is handed.
    void subscribe() {
        broker::SessionImage image;
        image.header.client_id = "listener";
        image.subscriptions = {{.filter = "pose", .granted = mqttsn::Qos::at_least_once}};
        (void)broker.adopt(now, std::move(image), {}, clients);
    }
    /// What it is to get, in order.
    [[nodiscard]] std::vector<LogPosition> queued() const {
        std::vector<LogPosition> positions;
        const auto listener = broker.image("listener");
        for (const auto& delivery : listener->deliveries) {
            positions.push_back(delivery.position);
        }
        return positions;
    }
    /// The session comes from a home that had worked through `log` so far.
    void move_session(const LogId& to, const LogId& log, Seq seq) {
        apply(to, broker::Cursor{{{log, seq}}});
        apply(to, test::session("robot"));
    }

    Instant now{10s};
    broker::BrokerCore broker{broker::BrokerOptions{}, 1};
    broker::Actions clients;
    Outbox peers;
    std::vector<LocalAction> local;
    PeerLogs logs;
    View view;
    PublishOrder order{self.broker};
    std::size_t allowed = 256;  // in a turn
};

TEST_F(PublishOrderTest, WhatFollowsAMoveWaitsForWhatTheFormerHomeHad) {
    publish(former);
    move_session(next, former, 2);
    publish(next);
    EXPECT_EQ(broker.cursor(next), 0U);
    publish(former);
    EXPECT_EQ(broker.cursor(next), 3U);
}

TEST_F(PublishOrderTest, NothingWaitsWhenTheFormerHomesLogIsHere) {
    publish(former);
    move_session(next, former, 1);
    publish(next);
    EXPECT_EQ(broker.cursor(next), 3U);
}

TEST_F(PublishOrderTest, ALogThatWaitsIsWaitedFor) {
    move_session(next, former, 1);
    publish(next);  // 3
    move_session(third, next, 3);
    publish(third);  // 3
    EXPECT_EQ(broker.cursor(third), 0U);
    publish(former);
    EXPECT_EQ(broker.cursor(next), 3U);
    EXPECT_EQ(broker.cursor(third), 3U);
}

// Two logs that each go on with sessions from the other one would wait for each other in vain.
TEST_F(PublishOrderTest, ALogThatWaitsIsWaitedForNoFurtherThanNeeded) {
    apply(former, test::session("other"));
    move_session(next, former, 4);
    publish(next);  // 3
    apply(former, broker::Cursor{{{next, 2}}});
    apply(former, test::session("robot"));
    EXPECT_EQ(broker.cursor(next), 0U);
    publish(former);  // 4
    EXPECT_EQ(broker.cursor(former), 4U);
    EXPECT_EQ(broker.cursor(next), 3U);
}

TEST_F(PublishOrderTest, WhatWasAheadOfItsHomeCountsToo) {
    broker::SessionPut put{};
    put.image.header.client_id = "robot";
    put.image.worked_through = {{former, 1}};
    apply(next, put);
    publish(next);
    EXPECT_EQ(broker.cursor(next), 0U);
    publish(former);
    EXPECT_EQ(broker.cursor(next), 2U);
}

TEST_F(PublishOrderTest, NobodyWaitsLongerThanATailTakes) {
    move_session(next, former, 7);
    publish(next);
    expect_next_after(400ms, 3);
}

TEST_F(PublishOrderTest, NobodyWaitsForALogThatIsNotHeld) {
    move_session(next, test::log_of("unknown"), 7);
    publish(next);
    EXPECT_EQ(broker.cursor(next), 3U);
}

// One that was replaced heard more of it, and took that for worked through (simulator, seed
// 3125396).
TEST_F(PublishOrderTest, NobodyWaitsForWhatIsBeyondTheAgreedEndOfALog) {
    publish(former);
    logs.at(former).freeze();
    logs.at(former).end_at(1, {});
    move_session(next, former, 2);
    publish(next);
    EXPECT_EQ(broker.cursor(next), 3U);
}

TEST_F(PublishOrderTest, TheTailOfADeadBrokersLogIsWaitedFor) {
    publish(former);
    logs.at(former).freeze();
    move_session(next, former, 2);
    publish(next);
    EXPECT_EQ(broker.cursor(next), 0U) << "no end was agreed on yet";
    logs.at(former).end_at(2, {});
    carry_on();
    EXPECT_EQ(broker.cursor(next), 0U) << "its last event is to come";
    publish(former);
    EXPECT_EQ(broker.cursor(next), 3U);
}

TEST_F(PublishOrderTest, AMemberThatWasNotMetYetIsWaitedFor) {
    const LogId unmet = test::log_of("unmet");
    view.members = {unmet};
    move_session(next, unmet, 1);
    publish(next);
    EXPECT_EQ(broker.cursor(next), 0U);
    logs.try_emplace(unmet, unmet, 1'000);
    carry_on();
    EXPECT_EQ(broker.cursor(next), 0U);
    publish(unmet);
    EXPECT_EQ(broker.cursor(next), 3U);
}

TEST_F(PublishOrderTest, NobodyWaitsForTheOwnLog) {
    view.members = {self};
    move_session(next, self, 7);
    publish(next);
    EXPECT_EQ(broker.cursor(next), 3U);
}

TEST_F(PublishOrderTest, P8_WhatWaitsIsBounded) {
    move_session(next, former, 1);
    for (std::size_t i = 1; i < PublishOrder::held_most; ++i) publish(next);
    EXPECT_EQ(broker.cursor(next), 0U);
    publish(next);
    EXPECT_GT(broker.cursor(next), 0U);
    while (order.is_behind()) carry_on();
    EXPECT_EQ(broker.cursor(next), logs.at(next).applied());
}

// A client that moved while this broker was away has publishes in a snapshot, and later ones in
// another log; or the other way round.
TEST_F(PublishOrderTest, ASnapshotWaitsForAllThatTheOthersAreKnownToHave) {
    logs.at(former).heard_end(2, {});
    publish(former);
    snapshot(next, {3, 4}, 6);
    EXPECT_EQ(broker.cursor(next), 0U);
    publish(former);
    EXPECT_EQ(broker.cursor(next), 6U);
}

// What its home has worked through comes out of a stream of its own (simulator, `--fault stop
// --brokers 5 --acks 2`, seed 4201899).
TEST_F(PublishOrderTest, ASnapshotWaitsForWhatItsSessionsHaveWorkedThrough) {
    broker::SessionImage robot;
    robot.worked_through = {{former, 1}, {next, 4}};
    part(next, {3, 4}, {robot});
    carry_on();
    EXPECT_EQ(broker.cursor(next), 0U);
    publish(former);
    EXPECT_EQ(broker.cursor(next), 4U);
}

TEST_F(PublishOrderTest, ASnapshotThatNothingIsMissingForIsHandedOnAtOnce) {
    publish(former);
    snapshot(next, {3, 4}, 6);
    EXPECT_EQ(broker.cursor(next), 6U);
}

// Those that join publish for sessions that they adopt, and tell what these follow.
TEST_F(PublishOrderTest, WhatFollowsASnapshotWithoutPublishesWaitsForNothing) {
    logs.at(former).heard_end(1, {});
    snapshot(next, {}, 6);
    EXPECT_EQ(broker.cursor(next), 6U);
    publish(next);
    EXPECT_EQ(broker.cursor(next), 7U);
}

// Sessions come to us that say what they follow, and would go on here before what waits.
TEST_F(PublishOrderTest, ASnapshotWaitsForNothingWhereWeAreNew) {
    logs.at(next).set_apart(false);
    logs.at(former).heard_end(1, {});
    snapshot(next, {3}, 6);
    EXPECT_EQ(broker.cursor(next), 6U);
}

TEST_F(PublishOrderTest, ASnapshotDoesNotWaitForTheDead) {
    logs.at(former).heard_end(1, {});
    logs.at(former).freeze();
    snapshot(next, {3}, 6);
    EXPECT_EQ(broker.cursor(next), 6U);
}

TEST_F(PublishOrderTest, ASnapshotWaitsNoLongerThanASessionThatComes) {
    logs.at(former).heard_end(1, {});
    snapshot(next, {3}, 6);
    expect_next_after(100ms, 6);
}

// Its parts come again when one was lost.
TEST_F(PublishOrderTest, ASnapshotThatComesAnewIsHandedOnOnce) {
    subscribe();
    logs.at(former).heard_end(1, {});
    part(next, {3, 4});
    part(next, {3, 4});
    snapshot(next, {5}, 6);
    publish(former);
    EXPECT_EQ(broker.cursor(next), 6U);
    EXPECT_EQ(queued(), (std::vector<LogPosition>{{former, 1}, {next, 3}, {next, 4}, {next, 5}}));
}

TEST_F(PublishOrderTest, SnapshotsThatWaitForEachOtherGoOnWithWhatWasPublishedFirst) {
    subscribe();
    for (const LogId& log : {former, next}) logs.at(log).heard_end(4, {});
    snapshot(former, {1, 4}, 4);
    EXPECT_EQ(broker.cursor(former), 0U);
    snapshot(next, {2, 3}, 4);
    EXPECT_EQ(queued(), (std::vector<LogPosition>{{former, 1}, {next, 2}, {next, 3}, {former, 4}}));
    EXPECT_EQ(broker.cursor(next), 4U);
}

TEST_F(PublishOrderTest, WhoWaitsForOneThatWaitsForWhatIsNotHereIsInNoCircle) {
    for (const LogId& log : {former, next, third}) logs.at(log).heard_end(4, {});
    snapshot(former, {1}, 4);
    snapshot(next, {2}, 4);
    EXPECT_EQ(broker.cursor(former), 0U);
    EXPECT_EQ(broker.cursor(next), 0U);
    for (Seq seq = 1; seq <= 4; ++seq) publish(third);
    EXPECT_EQ(broker.cursor(former), 4U);
    EXPECT_EQ(broker.cursor(next), 4U);
}

TEST_F(PublishOrderTest, ACircleIsHandedOnInPieces) {
    for (const LogId& log : {former, next}) logs.at(log).heard_end(8, {});
    allowed = 0;
    snapshot(former, {1, 2, 3, 4, 5, 6, 7, 8}, 8);
    snapshot(next, {1, 2, 3, 4, 5, 6, 7, 8}, 8);
    while (order.is_behind()) {
        allowed = 3;
        const Seq before = broker.cursor(former) + broker.cursor(next);
        carry_on();
        EXPECT_LE(broker.cursor(former) + broker.cursor(next), before + 3);
    }
    EXPECT_EQ(broker.cursor(former), 8U);
    EXPECT_EQ(broker.cursor(next), 8U);
}

// Or a broker would be busy for longer than its peers wait for a beacon.
TEST_F(PublishOrderTest, WhatWaitedIsHandedOnInPieces) {
    allowed = 0;
    move_session(next, former, 1);
    for (int i = 0; i < 100; ++i) publish(next);  // 3..102
    publish(former);
    EXPECT_EQ(broker.cursor(next), 0U);
    EXPECT_TRUE(order.is_behind());
    allowed = 40;
    carry_on();
    EXPECT_EQ(broker.cursor(next), 42U);
    allowed = 0;
    publish(next);  // for one that comes two leave, in order
    EXPECT_EQ(broker.cursor(next), 44U);
    allowed = 100;
    carry_on();
    EXPECT_EQ(broker.cursor(next), 103U);
    EXPECT_FALSE(order.is_behind());
    publish(next);
    EXPECT_EQ(broker.cursor(next), 104U) << "nothing waits any more";
}

}  // namespace
}  // namespace romano::cluster::publish_order_test
