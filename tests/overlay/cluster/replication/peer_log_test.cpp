#include "overlay/cluster/replication/peer_log.h"

#include <gmock/gmock.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::peer_log_test {
namespace {

using namespace std::chrono_literals;
using test::address;
using test::erased;
using test::published;
using test::session;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

constexpr Instant start{1s};

struct Held {
    PeerLog log{test::log_of("b1"), 100};

    void take(Seq first, const std::vector<LogEventPtr>& events) {
        log.offer(first, events);
        while (log.has_next()) log.apply();
    }
    void restart_at(Seq as_of) {
        ASSERT_TRUE(log.offer({.as_of = {test::log_of("b1"), as_of}, .last = true}));
        ASSERT_TRUE(log.restart());
    }
    [[nodiscard]] std::vector<std::string> clients_left(const Endpoint& at) const {
        auto clients = log.clients_left(at);
        std::erase_if(clients, [this](const auto& client) { return !log.session_left(client); });
        return clients;
    }
};

TEST(PeerLog, AppliesInOrder) {
    Held held;
    held.take(1, {session("a"), session("b")});
    held.take(3, {erased("a")});
    EXPECT_EQ(held.log.applied(), 3U);
    EXPECT_FALSE(held.log.mirror().contains("a"));
    EXPECT_TRUE(held.log.mirror().contains("b"));
}

TEST(PeerLog, WhatComesTwiceCountsOnce) {
    Held held;
    held.take(1, {session("a"), session("b")});
    held.take(1, {session("a"), session("b"), session("c")});
    held.take(2, {session("b")});
    EXPECT_EQ(held.log.applied(), 3U);
}

TEST(PeerLog, WhatComesEarlyWaitsForTheGap) {
    Held held;
    held.take(3, {session("c")});
    held.take(4, {session("d")});
    EXPECT_EQ(held.log.applied(), 0U);
    held.take(1, {session("a"), session("b")});
    EXPECT_EQ(held.log.applied(), 4U);
}

TEST(PeerLog, WhatCameTwiceHoldsUpNothingThatFollowsIt) {
    Held held;
    held.take(3, {session("c"), session("d")});
    held.take(5, {session("e")});
    held.take(1, {session("a"), session("b"), session("c"), session("d")});
    EXPECT_EQ(held.log.applied(), 5U);
}

// P8: each of them called for the next one, once.
TEST(PeerLog, AGapBeforeManyBatchesCloses) {
    Held held;
    for (Seq seq = 2; seq <= 20'001; ++seq) held.take(seq, {session("a")});
    EXPECT_EQ(held.log.received(), 0U);
    held.take(1, {session("a")});
    EXPECT_EQ(held.log.applied(), 20'001U);
}

TEST(PeerLog, ASnapshotInPartsReplacesEverything) {
    Held held;
    held.take(1, {session("old")});
    SnapshotPart first{.as_of = {test::log_of("b1"), 50}, .part = 0};
    first.sessions.push_back(std::get<broker::SessionPut>(session("a")).image);
    SnapshotPart last{.as_of = first.as_of, .part = 1, .last = true};
    last.sessions.push_back(std::get<broker::SessionPut>(session("b")).image);
    EXPECT_TRUE(held.log.offer(first));
    EXPECT_FALSE(held.log.restart());
    EXPECT_TRUE(held.log.offer(last));
    EXPECT_EQ(held.log.restart(), (LogPosition{test::log_of("b1"), 50}));
    EXPECT_EQ(held.log.applied(), 50U);
    EXPECT_FALSE(held.log.mirror().contains("old"));
    EXPECT_TRUE(held.log.mirror().contains("a"));
    EXPECT_TRUE(held.log.mirror().contains("b"));
    held.take(51, {erased("a")});
    EXPECT_EQ(held.log.applied(), 51U);
}

// Its sessions go on changing while it is on its way.
TEST(PeerLog, WhatALaterPartSaysOfASessionReplacesWhatAnEarlierOneSaid) {
    const LogId b1 = test::log_of("b1");
    Held held;
    SnapshotPart first{.as_of = {b1, 50}, .since = 50};
    first.sessions = {std::get<broker::SessionPut>(session("a", address(1))).image,
                      std::get<broker::SessionPut>(session("b", address(1))).image};
    SnapshotPart last{.as_of = {b1, 60}, .since = 50, .part = 1, .last = true};
    last.sessions = {std::get<broker::SessionPut>(session("a", address(2))).image};
    last.gone = {"b", "never there"};
    held.take(52, {session("c")});  // it is in neither part's state; the last one's is newer
    ASSERT_TRUE(held.log.offer(first));
    ASSERT_TRUE(held.log.offer(last));
    EXPECT_EQ(held.log.restart(), (LogPosition{b1, 60}));
    EXPECT_EQ(held.log.applied(), 60U);
    EXPECT_EQ(held.log.mirror().size(), 1U);
    ASSERT_NE(held.log.mirror().header("a"), nullptr);
    EXPECT_EQ(held.log.mirror().header("a")->via, address(2));
}

TEST(PeerLog, PartsOfTwoSnapshotsAreNotOne) {
    const LogId b1 = test::log_of("b1");
    Held held;
    EXPECT_TRUE(held.log.offer({.as_of = {b1, 50}, .since = 50}));
    EXPECT_FALSE(held.log.offer({.as_of = {b1, 60}, .since = 55, .part = 1, .last = true}));
    EXPECT_FALSE(held.log.restart());
}

TEST(PeerLog, ASnapshotWithAMissingPartIsDropped) {
    Held held;
    const SnapshotPart first{.as_of = {test::log_of("b1"), 50}, .part = 0};
    const SnapshotPart third{.as_of = first.as_of, .part = 2, .last = true};
    EXPECT_TRUE(held.log.offer(first));
    EXPECT_FALSE(held.log.offer(third));
    EXPECT_FALSE(held.log.restart());
}

TEST(PeerLog, ThePublishesOfAnUnfinishedSnapshotAreFoundUntilTheHistoryHasThem) {
    const LogId b1 = test::log_of("b1");
    const auto part = [&](std::uint32_t number, std::initializer_list<Seq> publishes, bool last) {
        SnapshotPart made{.as_of = {b1, 50}, .part = number, .last = last};
        for (const Seq seq : publishes) {
            made.publishes.push_back(std::get<broker::Published>(published(b1, seq)).message);
        }
        return made;
    };
    const auto found = [](const PeerLog& log) {
        std::vector<Seq> seqs;
        for (const auto& message : log.publishes_after(2)) seqs.push_back(message->position.seq);
        return seqs;
    };
    Held held;
    EXPECT_TRUE(held.log.offer(part(0, {1, 3}, false)));
    EXPECT_THAT(found(held.log), ElementsAre(3));
    EXPECT_TRUE(held.log.publish_at(3));
    EXPECT_FALSE(held.log.publish_at(4));
    EXPECT_FALSE(held.log.offer(part(2, {40}, true))) << "a part is lost";
    EXPECT_THAT(found(held.log), ElementsAre(3));
    EXPECT_TRUE(held.log.offer(part(0, {1, 3}, false)));
    EXPECT_TRUE(held.log.offer(part(1, {20, 40}, true)));
    EXPECT_THAT(found(held.log), ElementsAre(3, 20, 40));
    EXPECT_TRUE(held.log.restart());
    EXPECT_THAT(found(held.log), ElementsAre(3, 20, 40));
}

TEST(PeerLog, EventsThatCameDuringASnapshotFollowIt) {
    Held held;
    held.take(51, {session("late")});
    held.restart_at(50);
    while (held.log.has_next()) held.log.apply();
    EXPECT_EQ(held.log.applied(), 51U);
    EXPECT_TRUE(held.log.mirror().contains("late"));
}

TEST(PeerLog, WhatIsHereAndFollowsASnapshotStays) {
    Held held;
    held.log.offer(1, {session("a"), session("b"), session("c")});  // not applied yet
    held.restart_at(2);
    ASSERT_TRUE(held.log.has_next());
    held.log.apply();
    EXPECT_FALSE(held.log.has_next());
    EXPECT_EQ(held.log.applied(), 3U);
    EXPECT_TRUE(held.log.mirror().contains("c"));
}

// P2: what is here beyond the agreed end would be in one member's mirror alone.
TEST(PeerLog, AFrozenLogDropsWhatWasNotAppliedYet) {
    Held held;
    held.take(1, {session("a")});
    held.log.offer(2, {session("b")});
    held.log.offer(4, {session("d")});
    held.log.freeze();
    EXPECT_FALSE(held.log.has_next());
    held.take(2, {session("b"), session("c")});  // a tail, up to the agreed end
    EXPECT_EQ(held.log.applied(), 3U);
    EXPECT_FALSE(held.log.mirror().contains("d"));
}

TEST(PeerLog, AFrozenLogKnowsWhatIsLeftToAdopt) {
    Held held;
    held.take(1, {session("a", address(1)), session("b", address(1)), session("c", address(2))});
    held.log.heard_serving({address(1), address(3)});
    held.log.freeze();
    EXPECT_THAT(held.log.addresses_left({}),
                UnorderedElementsAre(address(1), address(2), address(3)));
    EXPECT_EQ(held.clients_left(address(1)).size(), 2U);
    held.log.mark_taken("a");
    held.log.mark_taken("b");
    held.log.mark_served(address(1));
    EXPECT_THAT(held.clients_left(address(1)), IsEmpty());
    EXPECT_FALSE(held.log.session_left("a"));
    EXPECT_THAT(held.log.addresses_left({}), ElementsAre(address(2), address(3)));
}

const LogId heir = test::log_of("heir");

TEST(PeerLog, I5_AMovedSessionStaysAsItWasUntilItHasArrived) {
    Held held;
    auto put = session("a", address(1));
    std::get<broker::SessionPut>(put).image.unreleased = {mqttsn::MsgId{7}};
    auto move = test::moved(put, heir);
    std::get<broker::SessionMoved>(move).header.epoch = 5;
    held.take(1, {put, move, session("b")});
    EXPECT_FALSE(held.log.mirror().contains("a"));
    EXPECT_EQ(held.log.moved("a", 3), nullptr) << "by another event";
    const MovedSession* moved = held.log.moved("a", 2);
    ASSERT_NE(moved, nullptr);
    EXPECT_EQ(moved->to, heir);
    EXPECT_EQ(moved->image.header.epoch, 5U);
    EXPECT_EQ(moved->image.unreleased.size(), 1U);
    held.log.on_arrived("a", 1);
    EXPECT_NE(held.log.moved("a", 2), nullptr) << "that was an earlier move";
    held.log.on_arrived("a", 2);
    EXPECT_EQ(held.log.moved("a", 2), nullptr);
}

TEST(PeerLog, AMovedSessionThatArrivedBeforeTheEventIsHereIsOver) {
    Held held;
    held.log.on_arrived("a", 2);
    held.take(1, {session("a"), test::moved(session("a"), heir)});
    EXPECT_EQ(held.log.moved("a", 2), nullptr);
}

TEST(PeerLog, AMovedSessionThatIsTakenBackIsItsHomesAgain) {
    Held held;
    held.take(1, {session("a"), test::moved(session("a"), heir), session("a")});
    EXPECT_EQ(held.log.moved("a", 2), nullptr);
    EXPECT_TRUE(held.log.mirror().contains("a"));
}

/// "b1" moved "a" by its event 2, says its snapshot as of 9.
SnapshotPart with_moved(Seq at = 2) {
    SnapshotPart part{.as_of = {test::log_of("b1"), 9}, .last = true};
    part.gone.emplace_back("a");
    part.moved.push_back({std::get<broker::SessionPut>(session("a", address(1))).image, heir, at});
    return part;
}

TEST(PeerLog, I3_WhatASnapshotSaysOfMovedSessionsCounts) {
    Held held;
    ASSERT_TRUE(held.log.offer(with_moved()));
    ASSERT_TRUE(held.log.restart());
    EXPECT_NE(held.log.moved("a", 2), nullptr);
}

// P3: its writer has not read yet that the session arrived, and we have.
TEST(PeerLog, P3_ASnapshotDoesNotBringBackWhatHasArrived) {
    Held before;
    before.take(1, {session("a"), test::moved(session("a"), heir)});
    before.log.on_arrived("a", 2);
    ASSERT_TRUE(before.log.offer(with_moved()));
    ASSERT_TRUE(before.log.restart());
    EXPECT_EQ(before.log.moved("a", 2), nullptr);
    Held early;
    early.log.on_arrived("a", 2);
    ASSERT_TRUE(early.log.offer(with_moved()));
    ASSERT_TRUE(early.log.restart());
    EXPECT_EQ(early.log.moved("a", 2), nullptr);
}

TEST(PeerLog, WhatALaterPartSaysOfASessionCounts) {
    Held held;
    SnapshotPart moved = with_moved();
    moved.last = false;
    SnapshotPart back{.as_of = moved.as_of, .part = 1, .last = true};
    back.sessions.push_back(moved.moved[0].image);
    ASSERT_TRUE(held.log.offer(moved));
    ASSERT_TRUE(held.log.offer(back));
    ASSERT_TRUE(held.log.restart());
    EXPECT_TRUE(held.log.mirror().contains("a"));
    EXPECT_THAT(held.log.moved(), IsEmpty());
}

// I8: a snapshot of the new home's log does not say what it adopted before.
TEST(PeerLog, I8_WhatALivingHomeDoesNotTakeBackHasArrived) {
    Held held;
    held.take(1, {session("a"), test::moved(session("a"), heir)});
    held.log.forget_moved();
    EXPECT_NE(held.log.moved("a", 2), nullptr) << "it has some time";
    held.take(3, {session("b"), test::moved(session("b"), heir)});
    held.log.forget_moved();
    EXPECT_EQ(held.log.moved("a", 2), nullptr);
    EXPECT_NE(held.log.moved("b", 4), nullptr);
}

// P2: who is dead takes nothing back.
TEST(PeerLog, P2_WhatADeadHomeMovedIsKept) {
    Held held;
    held.take(1, {session("a"), test::moved(session("a"), heir)});
    held.log.forget_moved();
    held.log.freeze();
    held.log.forget_moved();
    held.log.forget_moved();
    EXPECT_NE(held.log.moved("a", 2), nullptr);
}

// P2: nobody else goes on for a client whose two homes are dead.
TEST(PeerLog, P2_WhatADeadBrokerMovedToNobodyInTheViewIsLeftWithIt) {
    Held held;
    PeerLogs logs;
    PeerLog& to = logs.try_emplace(heir, heir, 100).first->second;
    held.take(1, {session("a", address(1)), test::moved(session("a", address(1)), heir)});
    EXPECT_THAT(held.log.addresses_left({}), IsEmpty()) << "it lives";
    held.log.freeze();
    EXPECT_THAT(held.log.addresses_left({.members = {heir}}), IsEmpty());
    EXPECT_THAT(held.log.addresses_left({}), ElementsAre(address(1)));
    EXPECT_TRUE(held.log.call_back({.members = {heir}}, logs));
    EXPECT_THAT(held.clients_left(address(1)), IsEmpty()) << "the other home takes it";
    to.freeze();
    to.end_at(1, {});
    EXPECT_FALSE(held.log.call_back({}, logs)) << "it may have arrived: that log is not all here";
    EXPECT_THAT(held.clients_left(address(1)), IsEmpty());
    to.offer(1, {session("b")});
    to.apply();
    EXPECT_TRUE(held.log.call_back({}, logs));
    EXPECT_THAT(held.clients_left(address(1)), ElementsAre("a"));
    held.log.mark_taken("a");
    EXPECT_THAT(held.clients_left(address(1)), IsEmpty());
}

TEST(PeerLog, ATailOfAFrozenLogCounts) {
    Held held;
    held.take(1, {session("a", address(1)), session("b", address(1))});
    held.log.freeze();
    held.take(3, {erased("a"), session("c", address(1))});
    EXPECT_THAT(held.clients_left(address(1)), UnorderedElementsAre("b", "c"));
}

// P2: a member that missed the view in which the writer was taken back, with its sessions, is the
// next one's heir (simulator, faults `starve`, seed 142).
TEST(PeerLog, AWriterThatLivedOnHasItsSessionsAgain) {
    const ViewNumber removed{.term = 2};
    const ViewNumber taken_back{.term = 3};
    for (const bool is_heard : {false, true}) {
        Held held;
        held.take(1, {session("a", address(1)), session("b", address(1))});
        held.log.freeze();
        held.log.end_at(2, removed);
        held.log.mark_taken("a");
        if (is_heard) held.log.heard_end(4, taken_back);
        held.log.end_at(4, {.term = 4});
        held.take(3, {erased("b"), session("c", address(1))});
        if (is_heard) {
            EXPECT_THAT(held.clients_left(address(1)), UnorderedElementsAre("a", "c"));
        } else {
            EXPECT_THAT(held.clients_left(address(1)), ElementsAre("c"));
        }
    }
}

// P3: its last beacon, and the last events that another member held, come after its end was agreed
// on: the heir went on with its sessions, and would adopt them once more.
TEST(PeerLog, TheLastWordsOfADeadWriterLeaveNothingAgain) {
    const ViewNumber before{.term = 1};
    Held held;
    held.take(1, {session("a", address(1)), session("b", address(1))});
    held.log.freeze();
    held.log.end_at(2, {.term = 2});
    held.log.mark_taken("a");
    held.log.mark_taken("b");
    held.log.heard_end(4, before);
    held.log.end_at(3, {.term = 3});
    held.take(3, {published(test::log_of("b1"), 3)});
    EXPECT_THAT(held.log.clients_left(address(1)), IsEmpty());
}

// P3: only a member that was replaced holds more than was agreed on (heirs.h).
TEST(PeerLog, WhatStandsBeyondTheAgreedEndWasNotPublished) {
    Held held;
    const LogId writer = test::log_of("b1");
    held.take(1, {published(writer, 1), published(writer, 2), published(writer, 3)});
    held.log.freeze();
    held.log.end_at(2, {.term = 1});
    ASSERT_EQ(held.log.publishes_after(0).size(), 2U);
    EXPECT_TRUE(held.log.publish_at(2));
    EXPECT_FALSE(held.log.publish_at(3));
    EXPECT_TRUE(held.log.has_agreed_end());
    EXPECT_EQ(held.log.end(), 2U);
    held.log.heard_end(4, {.term = 2});
    EXPECT_EQ(held.log.end(), 3U) << "its writer lived on";
}

// The tail of a later view came before its announcement: whoever went on from that in the former
// one would not go on from what the others have (simulator, faults `starve`, seed 78).
TEST(PeerLog, I2_NothingIsTakenBeyondTheAgreedEnd) {
    Held held;
    const LogId writer = test::log_of("b1");
    held.take(1, {published(writer, 1)});
    held.log.freeze();
    held.log.end_at(2, {.term = 1});
    held.log.offer(2, {published(writer, 2), published(writer, 3)});
    EXPECT_FALSE(held.log.has_next());
    held.take(2, {published(writer, 2)});
    EXPECT_EQ(held.log.applied(), 2U);
    held.log.end_at(3, {.term = 2});
    held.take(3, {published(writer, 3)});
    EXPECT_EQ(held.log.applied(), 3U) << "the later view raised it";
}

// One that outranked the heir's copy would stop it from going on with that (simulator, faults
// `stop`, seed 57).
TEST(PeerLog, P2_AnOutdatedLogSaysNothingOfSessions) {
    Held held;
    held.take(1, {session("a", address(1))});
    held.log.become_outdated();
    EXPECT_NE(held.log.session("a"), nullptr) << "its writer lives";
    held.log.freeze();
    EXPECT_EQ(held.log.session("a"), nullptr);
    held.log.promised_with_writer();
    EXPECT_EQ(held.log.session("a"), nullptr) << "nothing comes to it before that view is there";
    held.log.thaw();
    held.log.freeze();
    EXPECT_NE(held.log.session("a"), nullptr) << "it died in a view that we were in";
}

TEST(PeerLog, P2_AWriterWithWhichAViewWasPromisedDiedBeforeOurEyes) {
    Held held;
    held.take(1, {session("a", address(1))});
    held.log.become_outdated();
    held.log.promised_with_writer();
    held.log.freeze();
    EXPECT_NE(held.log.session("a"), nullptr);
}

}  // namespace
}  // namespace romano::cluster::peer_log_test
