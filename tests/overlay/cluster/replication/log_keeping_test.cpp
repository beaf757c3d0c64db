#include "overlay/cluster/replication/log_keeping.h"

#include <gmock/gmock.h>

#include <chrono>
#include <string>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::log_keeping_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

const LogId self = test::log_of("self", 2);
const LogId writer = test::log_of("writer");
const LogId reader = test::log_of("reader");

/// A broker that knows two peers and holds ten events of the writer's log.
struct Keeper {
    Membership membership{ClusterOptions{}, self.broker, 1};
    ViewChange views{self};
    Watermark watermark{1};
    OwnLog own{self, 100'000};
    PeerLogs peers;
    LogKeeping keeping;
    Instant now{1s};
    std::uint64_t ticks = 0;

    Keeper() {
        hear(writer, {});
        hear(reader, {{writer, 4}});
        write(10);
    }
    void hear(const LogId& from, std::vector<LogPosition> applied) {
        membership.on_beacon(now, Beacon{.log = from,
                                         .tick = ++ticks,
                                         .hears = {self.broker},
                                         .applied = std::move(applied)});
        peers.try_emplace(from, from, 100'000);
    }
    void write(std::size_t events) {
        PeerLog& log = peers.at(writer);
        for (std::size_t i = 0; i < events; ++i) {
            const Seq seq = log.applied() + 1;
            log.offer(seq, {test::published(writer, seq)});
            while (log.has_next()) log.apply();
        }
    }
    void die(const LogId& peer) {
        peers.at(peer).freeze();
        Beacon last{.log = peer, .tick = ++ticks};
        last.leaving = true;
        membership.on_beacon(now, last);
    }
    Logs logs() { return {peers, own}; }
    std::vector<LogId> expire() {
        return keeping.expire(now, test::times, peers, membership, views);
    }
};

TEST(LogKeeping, AnEventStaysUntilEveryPeerHoldsIt) {
    Keeper keeper;
    keeper.write(events_per_batch);
    const Seq last = keeper.peers.at(writer).applied();
    keeper.keeping.forget_passed(keeper.now, test::times, keeper.logs(), keeper.membership,
                                 keeper.watermark);
    EXPECT_EQ(keeper.peers.at(writer).history().events_kept(), last - 4);
    keeper.hear(reader, {{writer, last}});
    keeper.keeping.forget_passed(keeper.now, test::times, keeper.logs(), keeper.membership,
                                 keeper.watermark);
    EXPECT_EQ(keeper.peers.at(writer).history().events_kept(), events_per_batch);
}

TEST(LogKeeping, AnOwnEventStaysUntilEveryPeerHasAcknowledgedIt) {
    Keeper keeper;
    constexpr Seq last = events_per_batch + 10;
    for (Seq seq = 1; seq <= last; ++seq) keeper.own.append(seq, test::published(self, seq));
    keeper.watermark.on_ack(writer, last);
    keeper.watermark.on_ack(reader, 4);
    const auto kept = [&keeper] {
        keeper.keeping.forget_passed(keeper.now, test::times, keeper.logs(), keeper.membership,
                                     keeper.watermark);
        return keeper.own.history().events_kept();
    };
    EXPECT_EQ(kept(), last - 4);
    keeper.watermark.on_ack(reader, last);
    EXPECT_EQ(kept(), events_per_batch);
}

// P2: an heir to the reader's sessions asks for it.
TEST(LogKeeping, AnOwnPublishStaysUntilThePeersSessionsHavePassedIt) {
    Keeper keeper;
    for (Seq seq = 1; seq <= 10; ++seq) keeper.own.append(seq, test::published(self, seq));
    const auto has_passed = [&keeper](const LogId& peer, Seq through) {
        PeerLog& log = keeper.peers.at(peer);
        log.offer(log.applied() + 1, {broker::Cursor{{{self, through}}}});
        while (log.has_next()) log.apply();
    };
    const auto kept = [&keeper] {
        const auto forget = [&keeper] {
            keeper.keeping.forget_passed(keeper.now, test::times, keeper.logs(), keeper.membership,
                                         keeper.watermark);
        };
        forget();
        keeper.now += test::times.passed_publishes_kept_for() + 1ms;
        forget();
        return keeper.own.history().publishes_after(0).size();
    };
    has_passed(writer, 10);
    has_passed(reader, 4);
    EXPECT_EQ(kept(), 6U);
    has_passed(reader, 10);
    EXPECT_EQ(kept(), 0U);
}

// P2: one that was out of sight when the last events were written, and has become heir to their
// writer since, gets them (simulator, faults `starve`, seed 142).
TEST(LogKeeping, TheLastBatchIsThereForAnHeirThatWasNoMember) {
    Keeper keeper;
    keeper.peers.at(reader).freeze();
    keeper.keeping.forget_passed(keeper.now, test::times, keeper.logs(), keeper.membership,
                                 keeper.watermark);
    Outbox out;
    const PeerLog& log = keeper.peers.at(writer);
    EXPECT_TRUE(send_tail(log.history(), {writer, log.end()}, 4, reader.broker, out));
    EXPECT_EQ(out.size(), 1U);
}

TEST(LogKeeping, ARemovedBrokersLogIsKeptForAWhile) {
    Keeper keeper;
    keeper.die(writer);
    EXPECT_THAT(keeper.expire(), IsEmpty());
    keeper.now += test::times.removed_log_kept_for() - 1s;
    EXPECT_THAT(keeper.expire(), IsEmpty());
    EXPECT_EQ(keeper.peers.at(writer).history().events_kept(), 10U);
    keeper.now += 1s;
    EXPECT_THAT(keeper.expire(), ElementsAre(writer));
}

TEST(LogKeeping, ABrokerThatCameBackInTimeKeepsItsLog) {
    Keeper keeper;
    keeper.die(writer);
    EXPECT_THAT(keeper.expire(), IsEmpty());
    keeper.now += test::times.removed_log_kept_for() * 2 / 3;
    keeper.peers.at(writer).thaw();
    keeper.hear(writer, {});
    EXPECT_THAT(keeper.expire(), IsEmpty());
    keeper.die(writer);
    keeper.now += test::times.removed_log_kept_for() * 2 / 3;
    EXPECT_THAT(keeper.expire(), IsEmpty());
}

TEST(LogKeeping, ALongLogGoesInPieces) {
    Keeper keeper;
    keeper.write(2 * LogHistory::most_at_once);
    keeper.die(writer);
    EXPECT_THAT(keeper.expire(), IsEmpty());
    keeper.now += test::times.removed_log_kept_for();
    int calls = 0;
    while (keeper.expire().empty()) {
        EXPECT_TRUE(keeper.keeping.is_behind());
        ASSERT_LT(++calls, 100);
    }
    EXPECT_FALSE(keeper.keeping.is_behind());
    EXPECT_GE(calls, 8);
}

TEST(LogKeeping, ALogIsOverWhenALaterLifeWasHeardAndNobodyHoldsIt) {
    Keeper keeper;
    const auto over = [&keeper](const LogId& log) {
        return is_over(log, keeper.logs(), keeper.membership);
    };
    EXPECT_FALSE(over(self));
    EXPECT_TRUE(over(test::log_of("self", 1)));
    EXPECT_FALSE(over(writer)) << "it is held here";
    EXPECT_FALSE(over(test::log_of("stranger")));

    keeper.peers.erase(writer);
    keeper.hear(test::log_of("writer", 2), {});
    EXPECT_FALSE(over(writer)) << "the reader holds it";
    keeper.hear(reader, {});
    EXPECT_TRUE(over(writer));
}

}  // namespace
}  // namespace romano::cluster::log_keeping_test
