#include "overlay/cluster/replication/fetching.h"

#include <gmock/gmock.h>

#include "overlay/cluster/replication/own_log.h"
#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::fetching_test {
namespace {

using namespace two_brokers;
using testing::ElementsAre;
using testing::IsEmpty;

const LogId dead = test::log_of("dead");
const LogId b1 = test::log_of("b1");
const LogId b2 = test::log_of("b2");

MATCHER_P2(Asks, holder, after, "") {
    return arg.to == holder.broker && std::get<Fetch>(arg.message).after == after &&
           std::get<Fetch>(arg.message).to == self.broker;
}

/// What "self" asks "peer", b1 and b2 for.
struct FetchingTest : testing::Test, Owner {
    FetchingTest() {
        for (const LogId& member : {peer, b1, b2}) says(member, {});
        view.members = {self, peer, b1, b2};
        std::ranges::sort(view.members);
    }
    void says(const LogId& member, std::vector<LogPosition> holds) {
        Beacon beacon{.log = member, .tick = ++tick, .hears = {self.broker}};
        beacon.applied = std::move(holds);
        (void)membership.on_beacon(now, beacon);
    }
    PeerLog& log_of(const LogId& id) { return logs.try_emplace(id, id, 1'000).first->second; }
    void take(const LogId& id, Seq first, Seq count, BrokerId from) {
        PeerLog& log = log_of(id);
        std::vector<LogEventPtr> events;
        for (Seq seq = first; seq < first + count; ++seq)
            events.push_back(test::published(id, seq));
        log.offer(first, events);
        Effects acting = effects();
        fetching.on_events(acting, from, *logs.find(id), count);
        while (log.has_next()) log.apply();
    }
    void remove(Seq end) {
        log_of(dead).freeze();
        fetching.on_view({.ends = {{dead, end}}});
    }
    /// What is asked for at this moment.
    std::vector<Outgoing> asked() {
        peers.clear();
        Effects acting = effects();
        fetching.carry_on(acting, logs, membership, view,
                          [this](const LogId&) { return inherits; });
        return peers;
    }
    std::vector<Outgoing> asked_after(Duration time) {
        for (const LogId& member : {peer, b1, b2}) EXPECT_TRUE(membership.is_alive(member));
        now += time;
        return asked();
    }

    std::uint64_t tick = 0;
    PeerLogs logs;
    Membership membership{ClusterOptions{}, self.broker, 1};
    View view;
    bool inherits = false;
    Fetching fetching{self.broker};
};

TEST_F(FetchingTest, AGapThatLastsIsAskedForAndAgainWhileItLasts) {
    take(peer, 1, 1, peer.broker);
    take(peer, 3, 1, peer.broker);
    EXPECT_THAT(asked(), IsEmpty());
    EXPECT_THAT(asked_after(10ms), IsEmpty());
    EXPECT_THAT(asked_after(10ms), ElementsAre(Asks(peer, LogPosition{peer, 1})));
    EXPECT_THAT(asked_after(10ms), IsEmpty());
    EXPECT_THAT(asked_after(10ms), ElementsAre(Asks(peer, LogPosition{peer, 1})));
    take(peer, 2, 1, peer.broker);
    EXPECT_THAT(asked_after(20ms), IsEmpty());
}

TEST_F(FetchingTest, ABeaconThatNamesALaterEndIsAGap) {
    take(peer, 1, 1, peer.broker);
    log_of(peer).heard_end(2, {});
    EXPECT_THAT(asked(), IsEmpty());
    EXPECT_THAT(asked_after(20ms), ElementsAre(Asks(peer, LogPosition{peer, 1})));
}

TEST_F(FetchingTest, ALogOfWhichNothingIsHereIsAskedForAtOnce) {
    log_of(peer).heard_end(2, {});
    EXPECT_THAT(asked(), ElementsAre(Asks(peer, LogPosition{peer, 0})));
}

TEST_F(FetchingTest, EachFullBatchAsksForTheNext) {
    take(peer, 1, 1, peer.broker);
    log_of(peer).heard_end(2 * events_per_batch, {});
    (void)asked();
    ASSERT_EQ(asked_after(20ms).size(), 1U);
    peers.clear();
    take(peer, 2, events_per_batch, peer.broker);
    EXPECT_THAT(peers, ElementsAre(Asks(peer, LogPosition{peer, events_per_batch + 1})));
    peers.clear();
    take(peer, events_per_batch + 2, events_per_batch - 1, peer.broker);
    EXPECT_THAT(peers, IsEmpty());
}

// A slow network would be full of the same events: each answer is all that the peer has.
TEST_F(FetchingTest, WhatComesInOrderIsNotAskedForOnceMore) {
    take(peer, 1, 1, peer.broker);
    log_of(peer).heard_end(10, {});
    (void)asked();
    ASSERT_EQ(asked_after(20ms).size(), 1U);
    peers.clear();
    take(peer, 2, 4, peer.broker);
    EXPECT_THAT(peers, IsEmpty());
    EXPECT_THAT(asked_after(10ms), IsEmpty());
    EXPECT_THAT(asked_after(20ms), ElementsAre(Asks(peer, LogPosition{peer, 5}))) << "no more came";
}

TEST_F(FetchingTest, TheOftenerItWasAskedForTheLongerItIsWaitedFor) {
    take(peer, 1, 1, peer.broker);
    log_of(peer).heard_end(2, {});
    (void)asked();
    for (const Duration waited : {20ms, 20ms, 40ms, 60ms, 80ms, 100ms, 100ms}) {
        for (Duration time = 10ms; time < waited; time += 10ms) {
            EXPECT_THAT(asked_after(10ms), IsEmpty());
            says(peer, {});
        }
        EXPECT_THAT(asked_after(10ms), ElementsAre(Asks(peer, LogPosition{peer, 1})));
        for (const LogId& member : {peer, b1, b2}) says(member, {});
    }
}

TEST_F(FetchingTest, WhileASnapshotComesItIsNotAskedForAgain) {
    log_of(peer).heard_end(50, {});
    ASSERT_EQ(asked().size(), 1U);
    for (int part = 0; part < 10; ++part) {
        now += 10ms;
        fetching.on_part(now, peer);
        EXPECT_THAT(asked(), IsEmpty());
    }
    EXPECT_EQ(asked_after(20ms).size(), 1U) << "no more comes";
}

TEST_F(FetchingTest, AFrozenLogAsksItsWriterForNothing) {
    take(peer, 1, 1, peer.broker);
    take(peer, 3, 1, peer.broker);
    log_of(peer).freeze();
    EXPECT_THAT(asked_after(20ms), IsEmpty());
    EXPECT_THAT(asked_after(20ms), IsEmpty());
}

TEST_F(FetchingTest, WhatAFrozenLogMissedIsAskedForAtOnceInTheViewThatHasItsWriter) {
    take(peer, 1, 1, peer.broker);
    log_of(peer).freeze();
    log_of(peer).heard_end(3, {});
    (void)asked();
    log_of(peer).thaw();
    fetching.on_view({});
    EXPECT_THAT(asked(), ElementsAre(Asks(peer, LogPosition{peer, 1})));
    EXPECT_THAT(asked_after(10ms), IsEmpty()) << "once";
}

// --- removed logs

TEST_F(FetchingTest, P2_WhatARemovedBrokerWroteIsAskedOfThoseWhoHoldIt) {
    says(b1, {{dead, 9}});
    remove(9);
    EXPECT_THAT(asked(), ElementsAre(Asks(b1, LogPosition{dead, 0})));
    EXPECT_TRUE(fetching.awaits({dead, 9}));
    EXPECT_FALSE(fetching.awaits({dead, 10})) << "beyond the end";
}

TEST_F(FetchingTest, ATailIsOnItsWayToWhoHoldsSomeOfIt) {
    take(dead, 1, 5, dead.broker);
    says(b1, {{dead, 9}});
    remove(9);
    EXPECT_THAT(asked(), IsEmpty());
    EXPECT_THAT(asked_after(20ms), ElementsAre(Asks(b1, LogPosition{dead, 5})));
    take(dead, 6, 4, b1.broker);
    EXPECT_THAT(asked_after(20ms), IsEmpty());
    EXPECT_FALSE(fetching.awaits({dead, 9}));
}

// One that has it from a snapshot has no events of it.
TEST_F(FetchingTest, WhenNothingComesTheNextHolderIsAsked) {
    says(b1, {{dead, 9}});
    says(b2, {{dead, 9}});
    remove(9);
    const auto first = asked();
    const auto second = asked_after(20ms);
    const auto third = asked_after(40ms);
    ASSERT_EQ(first.size() + second.size() + third.size(), 3U);
    EXPECT_NE(first[0].to, second[0].to);
    EXPECT_EQ(first[0].to, third[0].to);
}

TEST_F(FetchingTest, P2_PublishesAreEnoughForWhoInheritsNothing) {
    says(b1, {{dead, 9}});
    take(dead, 1, 5, dead.broker);
    remove(9);
    (void)asked();
    ASSERT_EQ(asked_after(20ms).size(), 1U);
    EXPECT_TRUE(fetching.on_last_publishes(now, b1.broker, {.as_of = {dead, 9}, .last = true}));
    EXPECT_FALSE(fetching.awaits({dead, 9}));
    inherits = true;
    EXPECT_THAT(asked_after(20ms), ElementsAre(Asks(b1, LogPosition{dead, 5})));
    inherits = false;
    EXPECT_THAT(asked_after(20ms), IsEmpty());
}

TEST_F(FetchingTest, P2_PublishesBehindAHoleAreNotTaken) {
    says(b1, {{dead, 9}});
    remove(9);
    ASSERT_EQ(asked().size(), 1U);
    const auto takes = [&](const SnapshotPart& part) {
        return fetching.on_last_publishes(now, b1.broker, part);
    };
    EXPECT_TRUE(takes({.as_of = {dead, 9}, .part = 0}));
    EXPECT_FALSE(takes({.as_of = {dead, 9}, .part = 2, .last = true}));
    EXPECT_TRUE(fetching.awaits({dead, 9}));
    EXPECT_EQ(asked_after(20ms).size(), 1U);
    EXPECT_TRUE(takes({.as_of = {dead, 9}, .part = 0}));
}

// They let different ones go: the parts of one say nothing of what the other's lack.
TEST_F(FetchingTest, P2_PublishesOfTwoHoldersAreNotMixed) {
    says(b1, {{dead, 9}});
    says(b2, {{dead, 9}});
    remove(9);
    const auto first = asked();
    ASSERT_EQ(first.size(), 1U);
    const BrokerId asked_first = first[0].to.value();
    EXPECT_TRUE(fetching.on_last_publishes(now, asked_first, {.as_of = {dead, 9}, .part = 0}));
    const auto second = asked_after(60ms);
    ASSERT_EQ(second.size(), 1U);
    ASSERT_NE(second[0].to, asked_first);
    EXPECT_FALSE(fetching.on_last_publishes(now, asked_first, {.as_of = {dead, 9}, .part = 0}));
    EXPECT_TRUE(
        fetching.on_last_publishes(now, second[0].to.value(), {.as_of = {dead, 9}, .part = 0}));
}

// --- messages that came from nowhere

const LogPosition unknown{test::log_of("unknown"), 7};

/// The peer is home to a robot for which two messages wait: one of the peer's own, and one that
/// "unknown" published.
struct MissingMessages : testing::Test, Cluster {
    MissingMessages() {
        hear(3);
        take(LogBatch{peer, 1, {test::session("robot", theirs), routed(own), routed(unknown)}});
        hear(3);
        asked_at_once = take_sent<Fetch>();
    }
    static LogEvent routed(const LogPosition& message) {
        return broker::Routed{message, {{"robot", mqttsn::Qos::at_least_once}}};
    }
    [[nodiscard]] std::size_t missing() const {
        return core.peer_logs().at(peer).mirror().unresolved().size();
    }
    std::size_t requests_in(Duration time) {
        std::size_t requests = 0;
        for (const Instant end = now + time; now < end;) {
            hear(3);
            for (const auto& request : take_sent<Fetch>()) {
                EXPECT_EQ(request.after, (LogPosition{peer, 0}));
                ++requests;
            }
        }
        return requests;
    }
    /// Of the peer's log as it was before what is held here of it.
    static SnapshotPart snapshot() {
        broker::SessionImage robot = image(0, theirs);
        robot.header.client_id = "robot";
        broker::Message message{};
        message.position = unknown;
        message.topic = "pose";
        robot.deliveries.push_back(
            {.position = unknown, .message = MessagePtr{std::move(message)}});
        return {.as_of = {peer, 2}, .last = true, .sessions = {std::move(robot)}};
    }

    [[nodiscard]] Seq acknowledged() const { return core.held_of(peer, core.peer_logs().at(peer)); }

    const LogPosition own{peer, 1};
    std::vector<Fetch> asked_at_once;
};

// Its log ended before this broker came: it is in no tail, and nobody sends it by itself.
TEST_F(MissingMessages, I6_WhatNamesAMessageOfAnEarlierLogIsAcknowledgedWhenThatIsHere) {
    ASSERT_EQ(asked_at_once.size(), 1U);
    EXPECT_EQ(asked_at_once.front().after, (LogPosition{unknown.log, 0}));
    EXPECT_EQ(acknowledged(), 2U);
    broker::Message message{};
    message.position = unknown;
    take(SnapshotPart{
        .as_of = {unknown.log, 9}, .last = true, .publishes = {MessagePtr{std::move(message)}}});
    EXPECT_EQ(missing(), 1U);
    EXPECT_EQ(acknowledged(), 3U);
}

TEST_F(MissingMessages, P1_WhatIsMissingForLongIsAskedOfItsHome) {
    ASSERT_EQ(missing(), 2U);
    EXPECT_EQ(requests_in(300ms), 0U) << "most comes a moment later";
    EXPECT_EQ(requests_in(300ms), 1U);
}

TEST_F(MissingMessages, P1_AnOldSnapshotBringsThem) {
    take(snapshot());
    EXPECT_EQ(missing(), 1U);
}

TEST_F(MissingMessages, WhatIsDeliveredIsMissedNoMore) {
    take(LogBatch{
        peer, 4, {broker::DeliveryEnded{"robot", own}, broker::DeliveryEnded{"robot", unknown}}});
    EXPECT_EQ(missing(), 0U);
    EXPECT_EQ(requests_in(1s), 0U);
}

}  // namespace
}  // namespace romano::cluster::fetching_test
