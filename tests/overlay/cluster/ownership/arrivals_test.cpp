// Sessions that their living homes moved here.
#include "overlay/cluster/ownership/arrivals.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::arrivals_test {
namespace {

using namespace two_brokers;
using namespace std::chrono_literals;
constexpr std::size_t sessions = 600;
constexpr std::size_t per_turn = 256;

/// "self" gets sessions from a live home, "peer".
struct NewHome : Owner {
    PeerLogs others;
    PeerLog& former = others.try_emplace(peer, peer, 10'000).first->second;
    OwnLog own{self, 10'000};
    Logs logs{others, own};
    Arrivals arrivals{self, per_turn};
    Departures departures{per_turn};
    Seq cursor = 0;                          // how far a third broker's log is worked through
    std::optional<LogId> higher_at;          // another copy that outranks those that come
    std::vector<Arrivals::Settled> settled;  // in the last turn

    void take(broker::LogEvent event) {
        former.offer(former.applied() + 1, {event});
        former.apply();
        arrivals.on_event(effects(), former, event);
    }
    void take(const broker::SessionImage& image, const LogId& to = self) {
        take(broker::SessionPut{image});
        take(broker::SessionMoved{image.header, to});
    }
    void take_snapshot(const SnapshotPart& part) {
        ASSERT_TRUE(former.offer(part));
        ASSERT_TRUE(former.restart());
        arrivals.on_snapshot(effects(), former);
    }
    void go_on() {
        arrivals.heed(now, [&](const LogPosition& position) {
            return position.log == peer || position.seq <= cursor;
        });
        arrivals.on_turn();
        carry_on();
    }
    void carry_on() {
        Effects acting = effects();
        settled = arrivals.carry_on(
            acting, logs, [this](const auto&) { return higher_at; }, departures);
    }
};

TEST(Arrivals, ManyAreAdoptedInPiecesAndThenTheAddressIsSettled) {
    NewHome home;
    for (std::size_t i = 0; i < sessions; ++i) home.take(image(i, ours));
    home.take(broker::Sealed{ours, self});
    home.take(broker::Sealed{theirs, test::log_of("third")});
    home.go_on();
    for (std::size_t adopted = per_turn; adopted < sessions; adopted += per_turn) {
        EXPECT_EQ(home.broker.session_count(), adopted);
        EXPECT_TRUE(home.arrivals.is_half_done());
        EXPECT_TRUE(home.settled.empty());
        home.carry_on();
        EXPECT_EQ(home.broker.session_count(), adopted) << "the turn has done its share";
        home.go_on();
    }
    EXPECT_EQ(home.broker.session_count(), sessions);
    EXPECT_FALSE(home.arrivals.is_half_done());
    ASSERT_EQ(home.settled.size(), 1U);
    EXPECT_EQ(home.settled.front().from, peer.broker);
    EXPECT_EQ(home.settled.front().address, ours);
    EXPECT_TRUE(home.former.moved().empty());
}

// I5: by that its former home knows that it need not take it back.
TEST(Arrivals, I5_TheAdoptionNamesTheMoveThatItAnswers) {
    NewHome home;
    home.take(image(0, ours));
    home.go_on();
    const auto& append = std::get<broker::Append>(home.clients.list().back());
    const auto& put = std::get<broker::SessionPut>(*append.event);
    EXPECT_EQ(put.adopted, (LogPosition{peer, 2}));
}

// What its client published at the former home is still to come here, and what it publishes next
// shall not pass it (simulator, seed 900899).
TEST(Arrivals, P5_TheyWaitForWhatTheFormerHomeHadWorkedThrough) {
    NewHome home;
    const auto move = [&](Seq worked_through) {
        auto session = image(worked_through, ours);
        session.worked_through = {{test::log_of("third"), worked_through}};
        home.take(session);
        home.go_on();
        return home.broker.session_count();
    };
    EXPECT_EQ(move(7), 0U);
    EXPECT_FALSE(home.arrivals.is_half_done()) << "nothing to do for the next turn";
    home.cursor = 7;
    home.go_on();
    EXPECT_EQ(home.broker.session_count(), 1U);

    EXPECT_EQ(move(8), 1U);
    home.now += 399ms;
    home.go_on();
    EXPECT_EQ(home.broker.session_count(), 1U);
    home.now += 1ms;
    home.go_on();
    EXPECT_EQ(home.broker.session_count(), 2U) << "it may never come";
}

TEST(Arrivals, P3_WhatWasTakenBackIsNotAdopted) {
    NewHome home;
    auto session = image(0, ours);
    session.worked_through = {{test::log_of("third"), 7}};
    home.take(session);
    home.take(broker::SessionPut{session});
    home.cursor = 7;
    home.go_on();
    EXPECT_EQ(home.broker.session_count(), 0U);
}

/// A snapshot of the former home, which has not read yet what arrived here.
SnapshotPart snapshot_with(const broker::SessionImage& image, Seq at) {
    SnapshotPart part{.as_of = {peer, 100}, .last = true};
    part.gone.push_back(image.header.client_id);
    part.moved.push_back({image, self, at});
    return part;
}

// It follows the log from behind the event.
TEST(Arrivals, P2_WhatASnapshotSaysIsMovedHereIsAdopted) {
    NewHome home;
    home.take_snapshot(snapshot_with(image(0, ours), 7));
    home.go_on();
    EXPECT_EQ(home.broker.session_count(), 1U);
}

// Its client may have said since that it wants no session any more.
TEST(Arrivals, P3_WhatWasAdoptedIsNotAdoptedFromASnapshotAgain) {
    NewHome home;
    home.take(image(0, ours));
    home.go_on();
    ASSERT_EQ(home.broker.session_count(), 1U);
    (void)home.broker.release(client(0), home.clients);
    home.take_snapshot(snapshot_with(image(0, ours), 2));
    home.go_on();
    EXPECT_EQ(home.broker.session_count(), 0U);
}

/// "self" has a copy of that rank, which it moves to "peer", and "peer" moves one of another rank
/// here: they cross.
struct Crossing : NewHome {
    Crossing(std::uint64_t own_epoch, std::uint64_t other_epoch) {
        auto session = image(0, theirs);
        session.header.epoch = own_epoch;
        (void)broker.adopt(now, session, {}, clients);
        Effects acting = effects();
        departures.move(acting, client(0), peer, 0, others);
        session.header.epoch = other_epoch;
        session.header.via = ours;
        take(session);
        go_on();
    }
    void take_back() {
        now += test::times.handover_acknowledged_within();
        Effects acting = effects();
        departures.carry_on(acting, logs, {.members = {self, peer}});
    }
};

// P3: after a heal each of two gave the other one its copy. The lower one was taken back in time,
// as one that had not arrived, and won (simulator, seed 300376).
TEST(Arrivals, P3_OfTwoCopiesThatCrossTheHigherOneIsTheSession) {
    Crossing home(1, 2);
    ASSERT_NE(home.broker.header(client(0)), nullptr);
    EXPECT_EQ(home.broker.header(client(0))->epoch, 2U);
    EXPECT_TRUE(home.departures.all().empty()) << "it is joined with that";
    home.take_back();
    EXPECT_EQ(home.broker.header(client(0))->epoch, 2U);
}

TEST(Arrivals, P3_TheLowerOfTwoCopiesThatCrossWaits) {
    Crossing home(2, 1);
    EXPECT_EQ(home.broker.header(client(0)), nullptr) << "the other home joins them";
    EXPECT_FALSE(home.arrivals.is_half_done()) << "there is nothing to do";
    home.take_back();
    home.go_on();
    EXPECT_EQ(home.broker.header(client(0))->epoch, 3U) << "it did not";
}

// Meanwhile the sessions lived on elsewhere (simulator, fault `stop`, acks all, seed 167).
TEST(Arrivals, P3_WhatWasMovedToAFormerLifeIsNotAdopted) {
    NewHome home;
    home.take(image(0, ours), test::log_of("self", 0));
    home.go_on();
    EXPECT_EQ(home.broker.session_count(), 0U);
}

TEST(Arrivals, P3_WhatWasCalledOffIsNotAdopted) {
    NewHome home;
    auto session = image(0, ours);
    session.worked_through = {{test::log_of("third"), 7}};
    home.take(session);
    home.former.heard_end(4, {});
    home.arrivals.forget_waiting(home.others);
    home.cursor = 7;
    home.go_on();
    EXPECT_EQ(home.broker.session_count(), 0U);
    home.take(image(1, ours));
    home.go_on();
    EXPECT_EQ(home.broker.session_count(), 0U) << "it was written before that";
    home.take(image(2, ours));
    home.go_on();
    EXPECT_EQ(home.broker.session_count(), 1U);
}

// Its home would take it back, and died before it did.
TEST(Arrivals, P2_WhatWasCalledOffAndIsNobodysIsAdopted) {
    NewHome home;
    home.take(image(0, ours));
    home.arrivals.forget_waiting(home.others);
    home.former.freeze();
    home.arrivals.on_end(home.effects(), home.former);
    home.go_on();
    EXPECT_EQ(home.broker.session_count(), 1U);
}

// Another home spoke to the client when its address came back with the lower copy: both did, until
// that had been adopted and settled (simulator, as shipped, seed 1827).
TEST(Arrivals, I7_WhereAnotherHomeHasAHigherCopyTheOneThatComesGoesOnThere) {
    NewHome home;
    home.higher_at = test::log_of("third");
    home.take(image(0, ours));
    home.go_on();
    EXPECT_EQ(home.broker.session_count(), 0U);
    ASSERT_TRUE(home.departures.all().contains(client(0)));
    EXPECT_EQ(home.departures.all().at(client(0)).session.to, home.higher_at);
    EXPECT_TRUE(home.former.moved().empty());
    std::vector<broker::LogEvent> written;
    for (const broker::Action& action : home.clients.list()) {
        written.push_back(*std::get<broker::Append>(action).event);
    }
    ASSERT_EQ(written.size(), 2U) << "and nothing is said";
    EXPECT_EQ(std::get<broker::SessionPut>(written.front()).adopted, (LogPosition{peer, 2}));
    EXPECT_EQ(std::get<broker::SessionMoved>(written.back()).to, home.higher_at);
}

// Of that one the own log would say that it is gone.
TEST(Arrivals, I7_WhatComesIsJoinedWithTheOwnSessionThoughAnotherHomeHasAHigherCopy) {
    NewHome home;
    (void)home.broker.adopt(home.now, image(0, ours), {}, home.clients);
    home.higher_at = test::log_of("third");
    home.take(image(0, ours));
    home.go_on();
    EXPECT_EQ(home.broker.session_count(), 1U);
    EXPECT_TRUE(home.departures.all().empty());
}

struct Home : InAView {
    void take_moved(const broker::SessionImage& image) {
        const broker::SessionPut put{image};
        take(LogBatch{.log = peer, .first_seq = 1, .events = {put, test::moved(put, self)}});
    }
    void stand_still(Duration away) {
        now += away;
        EXPECT_TRUE(core.notice_standstill(now));
    }
    [[nodiscard]] bool has_given_away() const {
        const auto& history = core.own_log().history();
        return std::ranges::any_of(history.events_after(0, 1'000), [](const auto& event) {
            return std::holds_alternative<broker::SessionMoved>(*event);
        });
    }
};

/// "self" stood still, and reads that it is given a session before the peer echoes.
std::size_t adopted_after_a_stall(Duration away, bool was_left_out) {
    Home home;
    home.stand_still(away);
    home.take_moved(image(0, ours));
    EXPECT_EQ(home.broker.session_count(), 0U) << "not without a lease";
    if (was_left_out) {
        home.take(Beacon{.name = "peer",
                         .log = peer,
                         .tick = ++home.ticks,
                         .view = {.number = {100, self.broker, 2}, .members = {peer}}});
    }
    home.tick();
    home.hear();
    return home.broker.session_count();
}

TEST(Arrivals, P2_ANewcomerAdoptsWhatItsFirstSnapshotSaysIsMovedHere) {
    Home home;
    home.Cluster::take(snapshot_with(image(0, ours), 7));
    EXPECT_EQ(home.broker.session_count(), 1U);
}

TEST(Arrivals, WhatCameInAStallIsAdoptedAfterIt) {
    EXPECT_EQ(adopted_after_a_stall(100ms, false), 1U);
}

// P3: its home had called that off long ago, and had delivered since what it would say again
// (simulator, faults `relapse`, seeds 9992292 and 9992392).
TEST(Arrivals, P3_WhatCameInAStallIsNotAdoptedWhenItsHomeWentOn) {
    EXPECT_EQ(adopted_after_a_stall(100ms, true), 0U);
    EXPECT_EQ(adopted_after_a_stall(1s, false), 0U);
}

// As the cluster core has it: of two peers one is home to the client, and the other hands over what
// it had of it.
TEST(Arrivals, I7_ASessionThatASecondPeerHandsOverIsNotSpokenForBesideTheFirstOnes) {
    Home home;
    broker::SessionImage copy = image(0, theirs);
    copy.header.epoch = 2;
    home.Cluster::take(LogBatch{.log = peer, .first_seq = 1, .events = {broker::SessionPut{copy}}});
    const LogId second = test::log_of("second");
    Effects acting = home.effects();
    hear(home.core, acting, Beacon{.log = second, .tick = 1, .hears = {self.broker}});
    const broker::SessionPut put{image(0, ours)};
    home.core.on_message(
        acting,
        {second, LogBatch{.log = second, .first_seq = 1, .events = {put, test::moved(put, self)}}});
    EXPECT_EQ(home.broker.session_count(), 0U);
    EXPECT_TRUE(home.core.departures().all().contains(client(0)));
}

// They may have lived on elsewhere since; whoever asks asks again.
TEST(Arrivals, P4_WhoMayHaveBeenReplacedGivesNoneAway) {
    Home home;
    (void)home.broker.adopt(home.now, image(0, ours), {}, home.clients);
    home.keep_log();
    home.stand_still(100ms);
    home.take(SessionRequest{client(0), theirs});
    EXPECT_FALSE(home.has_given_away());
    home.tick();
    home.hear();
    home.take(SessionRequest{client(0), theirs});
    EXPECT_TRUE(home.has_given_away());
}

// P2: it had given the address to its own broker, which had come back meanwhile; there it was asked
// for nothing, because the robot only listened (simulator, faults `relapse`, seed 9851485).
TEST(Arrivals, P2_WhoHasLetTheAddressGoServesItOnceMore) {
    Cluster holder;
    holder.hear();
    const broker::SessionPut put{image(0, theirs)};
    holder.take(LogBatch{.log = peer,
                         .first_seq = 1,
                         .events = {put, test::moved(put, self), broker::Sealed{theirs, self}}});
    EXPECT_EQ(holder.broker.session_count(), 1U);
    EXPECT_TRUE(holder.core.addresses().is_taking(theirs)) << "to hand it to its broker with it";
}

}  // namespace
}  // namespace romano::cluster::arrivals_test
