// A broker that is busy for longer than its peers wait for a beacon is taken for dead; then there
// is yet more to catch up with. So no input takes long, however much is to be done.
#include <gtest/gtest.h>

#include "overlay/cluster/cluster_core.h"
#include "tests/overlay/cluster/beacons.h"
#include "tests/overlay/cluster/events.h"

namespace romano::cluster::catching_up_test {
namespace {

using namespace std::chrono_literals;

const LogId self = test::log_of("self");
const LogId peer = test::log_of("peer");

/// A member that hears one peer, and what that one is sent.
class CatchingUp : public testing::Test {
protected:
    CatchingUp() {
        for (int i = 0; i < 5; ++i) hear_beacon(0);
    }

    void take(ClusterMessage message, const LogId& from = peer) {
        Effects acting = effects();
        core.on_message(acting, {from, std::move(message)});
    }
    void take(const Beacon& beacon) {
        Effects acting = effects();
        cluster::hear(core, acting, beacon);
    }
    void tick() {
        Effects acting = effects();
        core.on_tick(acting, {});
    }
    void hear_beacon(Seq last) {
        now += 10ms;
        take(Beacon{.name = "peer",
                    .log = peer,
                    .last_seq = last,
                    .tick = ++ticks,
                    .hears = {self.broker}});
        tick();
    }
    void take_batch(Seq first, Seq count) {
        LogBatch batch{.log = peer, .first_seq = first};
        for (Seq seq = first; seq < first + count; ++seq) {
            batch.events.push_back(test::published(peer, seq));
        }
        take(std::move(batch));
    }
    /// A third broker gives us a subscriber that has worked through so much.
    void hand_over_robot(const LogPosition& worked_through) {
        const LogId home = test::log_of("home");
        take(Beacon{.name = "home", .log = home, .tick = 1, .hears = {self.broker}});
        broker::SessionPut put{};
        broker::SessionImage& image = put.image;
        image.header.client_id = "robot";
        image.subscriptions = {{.filter = "pose", .granted = mqttsn::Qos::at_least_once}};
        image.worked_through = {worked_through};
        take(LogBatch{.log = home, .first_seq = 1, .events = {put, test::moved(put, self)}});
    }
    [[nodiscard]] Seq applied() const { return core.peer_logs().at(peer).applied(); }
    [[nodiscard]] Effects effects() { return {now, broker, clients, out, local, test::times}; }
    template <typename Kind>
    [[nodiscard]] std::vector<Kind> take_sent() {
        std::vector<Kind> sent;
        for (auto& outgoing : out) {
            if (auto* message = std::get_if<Kind>(&outgoing.message)) sent.push_back(*message);
        }
        out.clear();
        return sent;
    }

    Instant now{10s};
    std::uint64_t ticks = 0;
    ClusterOptions options;
    broker::BrokerCore broker{test::writer_of(self), 1};
    broker::Actions clients;
    Outbox out;
    std::vector<LocalAction> local;
    ClusterCore core{options, {.name = "self", .log = self, .home_addresses = {}}, 1};
};

TEST_F(CatchingUp, AGapThatClosesIsWorkedThroughInPieces) {
    for (Seq first = 2; first < 10'000; first += 100) take_batch(first, 100);
    EXPECT_EQ(applied(), 0U);
    take_batch(1, 1);
    EXPECT_EQ(applied(), 2U);
    (void)take_sent<LogAck>();
    while (applied() < 10'001) {
        ASSERT_EQ(core.next_wakeup(), Instant::min()) << "there is more to do";
        const Seq before = applied();
        tick();
        ASSERT_GT(applied(), before);
        ASSERT_LE(applied(), before + options.events_per_turn);
        const auto acks = take_sent<LogAck>();
        ASSERT_EQ(acks.size(), 1U);
        EXPECT_EQ(acks[0].through.seq, applied()) << "only what is applied is acknowledged";
    }
    EXPECT_GT(core.next_wakeup(), now);
    EXPECT_EQ(broker.cursor(peer), 10'001U);
}

TEST_F(CatchingUp, WhatComesMeanwhileIsWorkedThroughTwiceAsFast) {
    for (Seq first = 2; first < 1'000; first += 100) take_batch(first, 100);
    take_batch(1, 1);
    const Seq before = applied();
    take_batch(1'002, 50);
    EXPECT_EQ(applied(), before + 100);
}

// I8: a turn of the daemon reads many messages, and then it ticks.
TEST_F(CatchingUp, SessionsOfManyMessagesAreWorkedThroughInPieces) {
    const Seq per_turn = options.sessions_per_turn;
    for (Seq first = 1; first < 1'000; first += 100) {
        LogBatch batch{.log = peer, .first_seq = first};
        for (Seq seq = first; seq < first + 100; ++seq) {
            batch.events.push_back(test::session("robot" + std::to_string(seq)));
        }
        take(std::move(batch));
    }
    EXPECT_EQ(applied(), per_turn);
    while (applied() < 1'000) {
        ASSERT_EQ(core.next_wakeup(), Instant::min()) << "there is more to do";
        const Seq before = applied();
        tick();
        EXPECT_EQ(applied(), std::min<Seq>(before + per_turn, 1'000));
        EXPECT_EQ(take_sent<LogAck>().back().through.seq, applied());
    }
}

// A newcomer was behind for longer than sessions wait for it (simulator, seed 40584).
TEST_F(CatchingUp, WhatStandsBehindManySessionsWaitsForNothingElse) {
    LogBatch batch{.log = peer, .first_seq = 1};
    for (Seq seq = 1; seq <= options.sessions_per_turn + 1; ++seq) {
        batch.events.push_back(test::session("robot" + std::to_string(seq)));
    }
    for (Seq i = 0; i < 2 * options.events_per_turn; ++i) {
        batch.events.push_back(test::published(peer, batch.events.size() + 1));
    }
    const Seq last = batch.events.size();
    take(std::move(batch));
    ASSERT_EQ(applied(), options.sessions_per_turn);
    tick();
    EXPECT_EQ(applied(), last);
}

TEST_F(CatchingUp, WhoIsCaughtUpWithAsksForNothing) {
    for (Seq first = 2; first < 1'000; first += 100) take_batch(first, 100);
    take_batch(1, 1);
    (void)take_sent<Fetch>();
    for (int i = 0; i < 10; ++i) {
        now += 10ms;
        take(Beacon{.name = "peer", .log = peer, .last_seq = 1'001, .tick = ++ticks});
        EXPECT_TRUE(take_sent<Fetch>().empty());
    }
}

TEST_F(CatchingUp, ASnapshotLeavesInPiecesAndOnce) {
    constexpr Seq publishes = 5'000;
    for (Seq seq = 1; seq <= publishes; ++seq) core.append(seq, test::published(self, seq));
    const auto request = [&] { take(Fetch{.after = {self, 0}, .to = peer.broker}); };
    (void)take_sent<SnapshotPart>();
    request();
    std::size_t sent = 0;
    std::uint32_t next_part = 0;
    for (bool last = false; !last;) {
        for (const SnapshotPart& part : take_sent<SnapshotPart>()) {
            EXPECT_EQ(part.part, next_part++);
            EXPECT_EQ(part.as_of, (LogPosition{self, publishes}));
            sent += part.publishes.size();
            last = part.last;
        }
        ASSERT_LE(sent, 256U * next_part);
        if (last) break;
        ASSERT_LE(core.next_wakeup(), now + 10ms);
        now = std::max(now, core.next_wakeup());
        request();  // the peer is impatient
        tick();
    }
    EXPECT_EQ(sent, publishes);
    now += 10ms;
    request();
    tick();
    EXPECT_FALSE(take_sent<SnapshotPart>().empty()) << "who asks later gets another one";
}

TEST_F(CatchingUp, ThePublishesOfASnapshotAreHandedOnAsTheyCome) {
    SnapshotPart part{.as_of = {peer, 1'000}};
    for (Seq seq = 1; seq <= 10; ++seq) {
        part.publishes.push_back(std::get<broker::Published>(test::published(peer, seq)).message);
    }
    take(part);
    EXPECT_EQ(broker.cursor(peer), 10U);
    EXPECT_EQ(applied(), 0U) << "but the log goes on only from a whole snapshot";
    SnapshotPart last{.as_of = part.as_of, .part = 1, .last = true};
    take(last);
    EXPECT_EQ(broker.cursor(peer), 1'000U);
    EXPECT_EQ(applied(), 1'000U);
}

// It would not outlive its home and its publisher's broker (simulator, seed 9951843).
TEST_F(CatchingUp, P3_AMessageThatAHomeWorksOnIsAcknowledgedWhenTheMessageIsHereToo) {
    const LogId publisher = test::log_of("publisher");
    const auto hear_publisher = [&] {
        take(
            Beacon{.name = "publisher", .log = publisher, .tick = ++ticks, .hears = {self.broker}});
    };
    while (!core.leadership().leader) {
        hear_publisher();
        hear_beacon(0);
    }
    ViewAnnouncement announcement{
        .view = {.number = {100, self.broker, 1}, .members = {self, peer, publisher}}};
    std::ranges::sort(announcement.view.members);
    take(announcement);
    (void)take_sent<LogAck>();

    take_batch(1, 1);
    take(LogBatch{.log = peer,
                  .first_seq = 2,
                  .events = {broker::Routed{.message = {publisher, 1}, .routes = {}}}});
    EXPECT_EQ(applied(), 2U);
    EXPECT_EQ(take_sent<LogAck>().back().through, (LogPosition{peer, 1}));
    take(LogBatch{.log = publisher, .first_seq = 1, .events = {test::published(publisher, 1)}},
         publisher);
    const auto acks = take_sent<LogAck>();
    EXPECT_TRUE(std::ranges::any_of(acks, [](const LogAck& ack) {
        return ack.through == LogPosition{peer, 2};
    }));
}

// They are here whenever we live; to wait for them in a copy of our log was to wait for ever.
TEST_F(CatchingUp, WhatNamesAMessageOfOurOwnIsAcknowledged) {
    while (!core.leadership().leader) hear_beacon(0);
    ViewAnnouncement announcement{
        .view = {.number = {100, self.broker, 1}, .members = {self, peer}}};
    std::ranges::sort(announcement.view.members);
    take(announcement);
    take(LogBatch{.log = peer,
                  .first_seq = 1,
                  .events = {broker::Routed{.message = {self, 1}, .routes = {}}}});
    EXPECT_EQ(core.beacon(broker).applied_through(peer), 1U);
}

// I6: the silence of the message's broker was enough to acknowledge what names the message.
TEST_F(CatchingUp, WhatNamesAMessageOfASilentBrokerWaitsForTheViewThatEndsItsLog) {
    const LogId publisher = test::log_of("publisher");
    while (!core.leadership().leader) {
        take(
            Beacon{.name = "publisher", .log = publisher, .tick = ++ticks, .hears = {self.broker}});
        hear_beacon(0);
    }
    ViewAnnouncement announcement{
        .view = {.number = {100, self.broker, 1}, .members = {self, peer, publisher}}};
    std::ranges::sort(announcement.view.members);
    take(announcement);
    take_batch(1, 1);
    take(LogBatch{.log = peer,
                  .first_seq = 2,
                  .events = {broker::Routed{.message = {publisher, 1}, .routes = {}}}});
    const auto acknowledged = [&] { return core.beacon(broker).applied_through(peer); };
    while (core.membership().is_alive(publisher)) hear_beacon(2);
    EXPECT_EQ(acknowledged(), 1U);

    ++announcement.view.number.count;
    std::erase(announcement.view.members, publisher);
    announcement.view.number.term = core.promised().term + 1;
    announcement.ends = {{publisher, 1}};
    take(announcement);
    EXPECT_EQ(acknowledged(), 1U) << "it is before the end, so that it comes yet";
    take(LogBatch{.log = publisher, .first_seq = 1, .events = {test::published(publisher, 1)}});
    EXPECT_EQ(acknowledged(), 2U);
}

// A later view may go on from that log, and this broker stood still (simulator, faults `starve`,
// seed 194).
TEST_F(CatchingUp, I6_WhatIsBeyondTheEndOfARemovedLogIsWaitedForAfterAStandstill) {
    const LogId removed = test::log_of("removed");
    while (!core.leadership().leader) {
        take(Beacon{.name = "removed", .log = removed, .tick = ++ticks, .hears = {self.broker}});
        hear_beacon(0);
    }
    while (core.membership().is_alive(removed)) hear_beacon(0);
    ViewAnnouncement announcement{
        .view = {.number = {core.promised().term + 1, self.broker, 1}, .members = {self, peer}},
        .ends = {{removed, 1}}};
    std::ranges::sort(announcement.view.members);
    take(announcement);
    hear_beacon(0);
    const auto acknowledges = [&](Seq seq) {
        take(LogBatch{.log = peer,
                      .first_seq = seq,
                      .events = {broker::Routed{.message = {removed, 5}, .routes = {}}}});
        return core.beacon(broker).applied_through(peer) == seq;
    };
    ASSERT_TRUE(acknowledges(1)) << "nobody brings it";
    now += 1s;
    ASSERT_TRUE(core.notice_standstill(now));
    tick();
    EXPECT_FALSE(acknowledges(2));
}

/// The peer's log names a message of a broker that fell silent, and is in no view of ours.
class MessageOfASilentStranger : public CatchingUp {
protected:
    const LogId stranger = test::log_of("stranger");

    void meet_stranger() {
        take(Beacon{.name = "stranger", .log = stranger, .tick = 1, .hears = {self.broker}});
        ASSERT_TRUE(core.membership().is_alive(stranger));
    }
    [[nodiscard]] bool is_acknowledged() {
        EXPECT_FALSE(core.membership().is_alive(stranger));
        take(LogBatch{.log = peer,
                      .first_seq = 1,
                      .events = {broker::Routed{.message = {stranger, 1}, .routes = {}}}});
        return core.beacon(broker).applied_through(peer) == 1U;
    }
    void come_into_a_view() {
        while (!core.leadership().leader) hear_beacon(0);
        ViewAnnouncement announcement{
            .view = {.number = {100, self.broker, 1}, .members = {self, peer}}};
        std::ranges::sort(announcement.view.members);
        take(announcement);
        hear_beacon(0);
    }
};

// It is in the next view, perhaps (simulator, as shipped, seed 10308).
TEST_F(MessageOfASilentStranger, I6_IsWaitedForInNoView) {
    meet_stranger();
    while (core.membership().is_alive(stranger)) hear_beacon(0);
    EXPECT_FALSE(is_acknowledged());
    come_into_a_view();
    EXPECT_EQ(core.beacon(broker).applied_through(peer), 1U) << "it never was in one with us";
}

// Nobody brings it.
TEST_F(MessageOfASilentStranger, I6_IsNotWaitedForInAView) {
    come_into_a_view();
    meet_stranger();
    while (core.membership().is_alive(stranger)) hear_beacon(0);
    EXPECT_TRUE(is_acknowledged());
}

// It was not silent: this broker stood still (simulator, faults `relapse`, seed 832).
TEST_F(MessageOfASilentStranger, I6_IsWaitedForAfterAStandstill) {
    come_into_a_view();
    meet_stranger();
    now += 1s;
    ASSERT_TRUE(core.notice_standstill(now));
    for (; core.membership().is_alive(stranger); now += 10ms) tick();
    EXPECT_FALSE(is_acknowledged());
}

// I2: the leader asked how much is held here, and agrees on the end by the answer.
TEST_F(CatchingUp, AFrozenLogTakesNothingMoreFromItsWriter) {
    const LogId publisher = test::log_of("publisher");
    while (!core.leadership().leader) {
        take(
            Beacon{.name = "publisher", .log = publisher, .tick = ++ticks, .hears = {self.broker}});
        hear_beacon(0);
    }
    ViewAnnouncement announcement{
        .view = {.number = {100, self.broker, 1}, .members = {self, peer, publisher}}};
    std::ranges::sort(announcement.view.members);
    take(announcement);
    const PeerLog& log = core.peer_logs().at(publisher);
    take(LogBatch{.log = publisher, .first_seq = 1, .events = {test::published(publisher, 1)}},
         publisher);
    ASSERT_EQ(log.applied(), 1U);
    for (int i = 0; i < 200 && !log.is_frozen(); ++i) hear_beacon(0);
    ASSERT_TRUE(log.is_frozen());
    ASSERT_FALSE(log.agreed_end()) << "the members were asked, and have not agreed";
    take(LogBatch{.log = publisher, .first_seq = 2, .events = {test::published(publisher, 2)}},
         publisher);
    take(SnapshotPart{.as_of = {publisher, 10}, .last = true}, publisher);
    EXPECT_EQ(log.applied(), 1U);
}

// They have passed the broker by when the session comes (simulator, seed 970610).
TEST_F(CatchingUp, P2_ASessionThatComesAmidASnapshotGetsItsPublishes) {
    SnapshotPart part{.as_of = {peer, 1'000}};
    for (Seq seq = 1; seq <= 10; ++seq) {
        part.publishes.push_back(std::get<broker::Published>(test::published(peer, seq)).message);
    }
    take(part);
    hand_over_robot({peer, 6});
    const auto robot = broker.image("robot");
    ASSERT_TRUE(robot);
    EXPECT_EQ(robot->deliveries.size(), 4U);
}

// They have passed the broker by when the session comes (simulator, seed 2105858).
TEST_F(CatchingUp, P2_ASessionThatComesAfterTheLastWordsOfADeadBrokerGetsThem) {
    const LogId dead = test::log_of("dead");
    while (!core.leadership().leader) {
        take(Beacon{.name = "dead", .log = dead, .tick = ++ticks, .hears = {self.broker}});
        hear_beacon(0);
    }
    ViewAnnouncement announcement{
        .view = {.number = {100, self.broker, 1}, .members = {self, peer}}, .ends = {{dead, 10}}};
    std::ranges::sort(announcement.view.members);
    take(announcement);
    now += 10ms;
    take(Beacon{.name = "peer",
                .log = peer,
                .tick = ++ticks,
                .hears = {self.broker},
                .applied = {{dead, 10}}});
    tick();
    ASSERT_EQ(take_sent<Fetch>().size(), 1U);
    SnapshotPart part{.as_of = {dead, 10}, .last = true};
    for (Seq seq = 1; seq <= 10; ++seq) {
        part.publishes.push_back(std::get<broker::Published>(test::published(dead, seq)).message);
    }
    take(part);
    ASSERT_EQ(broker.cursor(dead), 10U);
    hand_over_robot({dead, 6});
    const auto robot = broker.image("robot");
    ASSERT_TRUE(robot);
    EXPECT_EQ(robot->deliveries.size(), 4U);
}

// What came before a lost part must not stand for what was in it.
TEST_F(CatchingUp, NothingOfASnapshotWithAHoleIsHandedOnBehindTheHole) {
    take(SnapshotPart{.as_of = {peer, 1'000}});
    SnapshotPart third{.as_of = {peer, 1'000}, .part = 2, .last = true};
    third.publishes.push_back(std::get<broker::Published>(test::published(peer, 900)).message);
    take(third);
    EXPECT_EQ(broker.cursor(peer), 0U);
    EXPECT_EQ(applied(), 0U);
}

}  // namespace
}  // namespace romano::cluster::catching_up_test
