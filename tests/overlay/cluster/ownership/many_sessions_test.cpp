// Thousands of sessions move in pieces: a broker that adopted all of them at once would be late for
// its peers. Until all are there nobody is a stranger, and nothing is said twice.
#include <gtest/gtest.h>

#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::many_sessions_test {
namespace {

using namespace two_brokers;
using namespace std::chrono_literals;

constexpr std::size_t sessions = 600;
constexpr std::size_t per_turn = ClusterOptions{}.sessions_per_turn;

TEST(ManySessions, AnHeirAdoptsThemInPieces) {
    Cluster heir;
    heir.serve(ours);
    for (int i = 0; i < 5; ++i) heir.hear(sessions);
    for (std::size_t first = 0; first < sessions; first += 100) {
        LogBatch batch{.log = peer, .first_seq = first + 1};
        for (std::size_t i = first; i < first + 100; ++i) {
            batch.events.push_back(test::session(client(i), theirs));
        }
        heir.take(std::move(batch));
    }
    bool are_listed = false;
    for (int i = 0; i < 100 && heir.broker.session_count() == 0; ++i) {
        are_listed = heir.core.take_over().is_half_adopted(theirs);
        heir.pass();
    }
    EXPECT_TRUE(are_listed) << "enough for the view's turn";
    ASSERT_EQ(heir.broker.session_count(), per_turn) << "the first ones when the peer is dead";
    heir.serve(theirs);
    while (heir.broker.session_count() < sessions) {
        ASSERT_EQ(heir.core.next_wakeup(), Instant::min());
        EXPECT_TRUE(heir.core.may_rest());
        EXPECT_TRUE(heir.waits_for_session(theirs, test::address(99))) << "no stranger yet";
        EXPECT_FALSE(heir.waits_for_session(ours, test::address(99)));
        const std::size_t before = heir.broker.session_count();
        heir.take(LogAck{});  // any other input
        ASSERT_EQ(heir.broker.session_count(), before);
        heir.tick();
        ASSERT_GT(heir.broker.session_count(), before);
        ASSERT_LE(heir.broker.session_count(), before + per_turn);
    }
    EXPECT_TRUE(heir.core.take_over().is_half_adopted(theirs)) << "to look for more is a turn, too";
    heir.tick();
    EXPECT_GT(heir.core.next_wakeup(), heir.now);
    EXPECT_FALSE(heir.core.may_rest());
    EXPECT_FALSE(heir.waits_for_session(theirs, test::address(99)));
}

/// "self" serves the address of "peer", which is back and serves it as well.
struct Holder : Owner {
    Membership membership{ClusterOptions{}, self.broker, 1};
    ServiceAddresses addresses{{ours}};
    HandBack hand_back;
    Departures departures{per_turn};
    PeerLogs logs;
    OwnLog own{self, 100};
    View view{.members = {self, peer}};

    /// The owner binds its address yet, or speaks there.
    explicit Holder(std::vector<Endpoint> binding = {}, std::size_t moved_per_turn = sessions)
        : hand_back{self.broker, moved_per_turn} {
        std::ranges::sort(view.members);
        addresses.on_address(ours, true);
        addresses.on_address(theirs, true);
        membership.on_beacon(now, Beacon{.log = peer,
                                         .tick = 1,
                                         .hears = {self.broker},
                                         .applied = {{self, 1}},
                                         .home_addresses = {theirs},
                                         .serving = {theirs},
                                         .binding = std::move(binding)});
        Effects acting = effects();
        hand_back.compare(acting, membership, view, addresses);
        for (std::size_t i = 0; i < sessions; ++i) {
            (void)broker.adopt(now, image(i, theirs), {}, clients);
        }
        clients.clear();
    }
    void carry_on(const std::set<Endpoint>& half_adopted = {},
                  const std::set<Endpoint>& inheriting = {}) {
        Effects acting = effects();
        hand_back.carry_on(
            acting, {logs, own}, membership, view, addresses, departures,
            {.pending_output = {}, .half_adopted = half_adopted, .inheriting = inheriting});
    }
    /// The owner has all that have left.
    void arrive() {
        for (const auto& [name, leaving] : std::map{departures.all()}) {
            departures.on_arrived(name, leaving.session.at);
        }
    }
    /// Until all have left, and the address is sealed.
    void move_all() {
        carry_on();
        now += 5ms;
        do {
            carry_on();
        } while (hand_back.is_half_done(departures));
    }
    template <typename Event>
    [[nodiscard]] std::vector<Event> take_written() {
        std::vector<Event> written;
        for (broker::Action& action : clients.list()) {
            const auto* append = std::get_if<broker::Append>(&action);
            if (append == nullptr) continue;
            if (auto* event = std::get_if<Event>(&*append->event)) written.push_back(*event);
        }
        clients.clear();
        return written;
    }
};

// I5: or they would be nobody's, at an address that is let go.
TEST(ManySessions, I5_WhatAnHeirAdoptsThereMeanwhileLeavesBeforeTheSeal) {
    Holder holder{{}, 400};
    holder.carry_on();
    holder.now += 5ms;
    holder.carry_on();
    (void)holder.broker.adopt(holder.now, image(sessions, theirs), {}, holder.clients);
    holder.clients.clear();
    for (int i = 0; i < 5; ++i) {
        holder.arrive();
        holder.carry_on({theirs});
    }
    EXPECT_TRUE(holder.take_written<broker::Sealed>().empty()) << "more are to be adopted";
    holder.move_all();
    EXPECT_EQ(holder.take_written<broker::Sealed>().size(), 1U);
    EXPECT_EQ(holder.broker.session_count(), 0U);
}

TEST(ManySessions, TheyAreHandedBackInPieces) {
    Holder holder{{}, per_turn};
    holder.carry_on();
    holder.now += 5ms;
    std::size_t left = sessions;
    do {
        if (holder.departures.all().size() > per_turn) {
            EXPECT_FALSE(holder.hand_back.is_half_done(holder.departures)) << "enough under way";
            holder.arrive();
        }
        holder.carry_on();
        EXPECT_TRUE(holder.hand_back.is_silent(theirs));
        std::size_t in_turn = 0;
        for (broker::Action& action : holder.clients.list()) {
            const auto* append = std::get_if<broker::Append>(&action);
            if (append == nullptr) continue;
            const auto* moved = std::get_if<broker::SessionMoved>(&*append->event);
            if (moved != nullptr) {
                EXPECT_EQ(moved->to, peer);
                EXPECT_TRUE(holder.departures.is_leaving(moved->header.address.endpoint));
                ++in_turn;
            }
            const auto* sealed = std::get_if<broker::Sealed>(&*append->event);
            if (sealed == nullptr) continue;
            EXPECT_EQ(left, in_turn) << "not before all have left";
            EXPECT_EQ(sealed->address, theirs);
            EXPECT_EQ(sealed->to, peer);
        }
        holder.clients.clear();
        ASSERT_GT(in_turn, 0U);
        ASSERT_LE(in_turn, per_turn);
        left -= in_turn;
        EXPECT_EQ(holder.broker.session_count(), left);
    } while (left > 0);
    ASSERT_FALSE(holder.departures.all().empty());
    holder.carry_on();
    EXPECT_TRUE(holder.addresses.is_serving(theirs)) << "they may come back";

    holder.arrive();
    holder.carry_on();
    EXPECT_FALSE(holder.addresses.is_serving(theirs));
}

/// The owner takes none yet, and as many are on their way as may be.
struct BusyHolder : Holder {
    BusyHolder() : Holder{{theirs}, per_turn} {
        carry_on();
        now += 5ms;
        carry_on();
        carry_on();
        EXPECT_EQ(departures.to(peer), 2 * per_turn);
    }
};

TEST(ManySessions, P7_OneThatIsWrittenToLeavesThoughManyAreOnTheirWay) {
    BusyHolder holder;
    holder.carry_on();
    EXPECT_EQ(holder.departures.to(peer), 2 * per_turn) << "enough are on their way";
    EXPECT_FALSE(holder.hand_back.is_half_done(holder.departures));
    std::size_t later = 0;
    while (holder.broker.header(client(later)) == nullptr) ++later;
    holder.hand_back.on_awaited(*holder.broker.header(client(later)));
    EXPECT_TRUE(holder.hand_back.is_half_done(holder.departures));
    EXPECT_TRUE(holder.hand_back.is_awaited());
    holder.carry_on();
    EXPECT_FALSE(holder.hand_back.is_awaited());
    EXPECT_EQ(holder.broker.header(client(later)), nullptr);
    EXPECT_EQ(holder.departures.to(peer), 2 * per_turn + 1);
}

// P1: or its address would be silent for as long as it does not answer.
TEST(ManySessions, P1_AnOwnerThatTakesNoneIsGivenNoMore) {
    BusyHolder holder;
    ASSERT_TRUE(holder.hand_back.is_silent(theirs));
    holder.now += 999ms;
    holder.carry_on();
    EXPECT_TRUE(holder.hand_back.is_silent(theirs));
    holder.now += 1ms;
    holder.carry_on({theirs});
    EXPECT_FALSE(holder.hand_back.is_silent(theirs));
}

// I7: the owner may have the later word, when it spoke there, too.
TEST(ManySessions, ThoseThatMoveOutrankWhatIsLeftOfThemUnlessTheOwnerSpokeToo) {
    for (const bool speaks : {false, true}) {
        Holder holder{speaks ? std::vector<Endpoint>{} : std::vector{theirs}};
        holder.move_all();
        const auto moved = holder.take_written<broker::SessionMoved>();
        ASSERT_EQ(moved.size(), sessions);
        EXPECT_EQ(moved[0].header.epoch, image(0, theirs).header.epoch + (speaks ? 0 : 1));
    }
}

// What it said for them comes first, from its log (simulator, seed 811931).
TEST(ManySessions, P3_ThoseThatTheOwnerMayHaveSpokenForAreSilentUntilItsHeirHasThem) {
    Holder holder;
    holder.move_all();
    (void)holder.membership.on_beacon(holder.now, {.log = peer, .tick = 2, .leaving = true});
    holder.carry_on();
    EXPECT_TRUE(holder.hand_back.is_silent(theirs)) << "a member, still";
    holder.view.members = {self};
    Effects acting = holder.effects();
    holder.hand_back.compare(acting, holder.membership, holder.view, holder.addresses);
    holder.carry_on({}, {theirs});
    EXPECT_TRUE(holder.hand_back.is_silent(theirs)) << "its log is not complete here";
    holder.carry_on();
    EXPECT_FALSE(holder.hand_back.is_silent(theirs));
}

// It said last that it serves the address, and nobody would.
TEST(ManySessions, P1_AnAddressIsNotLetGoToAnOwnerThatHasDied) {
    Holder holder;
    holder.move_all();
    holder.arrive();
    (void)holder.membership.on_beacon(
        holder.now,
        {.log = peer, .tick = 2, .home_addresses = {theirs}, .serving = {theirs}, .leaving = true});
    holder.view.members = {self};
    Effects acting = holder.effects();
    holder.hand_back.compare(acting, holder.membership, holder.view, holder.addresses);
    holder.carry_on({theirs}, {theirs});
    EXPECT_TRUE(holder.addresses.is_serving(theirs)) << "its heir, we, adopt still";
    holder.carry_on();
    EXPECT_TRUE(holder.addresses.is_serving(theirs));
    EXPECT_FALSE(holder.hand_back.is_silent(theirs));
}

// Those that move are taken back as those of one that is gone, and would be moved again.
TEST(ManySessions, I8_WhoIsNoMemberAnyMoreIsGivenNoMoreThoughItIsHeard) {
    Holder holder{{theirs}, per_turn};
    holder.carry_on();
    holder.now += 5ms;
    holder.carry_on();
    ASSERT_FALSE(holder.take_written<broker::SessionMoved>().empty());
    ASSERT_TRUE(holder.hand_back.is_half_done(holder.departures));
    holder.view.members = {self};
    holder.carry_on();
    EXPECT_FALSE(holder.hand_back.is_half_done(holder.departures));
    EXPECT_TRUE(holder.take_written<broker::SessionMoved>().empty());
}

// P3: what the owner had said is in its log, and its heir goes on from there (simulator, faults
// `relapse`, seed 9872321).
TEST(ManySessions, P3_OnlyThoseThatDidNotArriveComeBack) {
    Holder holder;
    PeerLog& owner = holder.logs.try_emplace(peer, peer, 10'000).first->second;
    holder.move_all();
    const auto take_back = [&] {
        Effects acting = holder.effects();
        holder.departures.carry_on(acting, {holder.logs, holder.own}, holder.view);
        return holder.broker.session_count();
    };
    EXPECT_EQ(take_back(), 0U);
    holder.view.members = {self};
    owner.freeze();
    owner.end_at(1, {});
    EXPECT_EQ(take_back(), 0U) << "its log is not complete here";
    owner.offer(1, {test::session("robot0", theirs)});
    owner.apply();
    holder.departures.on_arrived("robot0", holder.departures.all().at("robot0").session.at);
    EXPECT_EQ(take_back(), per_turn) << "in pieces, too";
    EXPECT_TRUE(holder.departures.is_half_done());
    while (holder.departures.is_half_done()) (void)take_back();
    EXPECT_EQ(holder.broker.session_count(), sessions - 1);
    EXPECT_EQ(holder.broker.header("robot0"), nullptr);
    EXPECT_EQ(holder.broker.header("robot1")->epoch, image(1, theirs).header.epoch + 1);
    EXPECT_FALSE(holder.departures.has_any_via(theirs));
}

TEST(ManySessions, ThoseThatNobodyAnswersForComeBack) {
    Holder holder;
    holder.logs.try_emplace(peer, peer, 100);
    holder.move_all();
    Effects acting = holder.effects();
    acting.now += 999ms;
    holder.departures.carry_on(acting, {holder.logs, holder.own}, holder.view);
    EXPECT_EQ(holder.broker.session_count(), 0U);
    acting.now += 1ms;
    holder.departures.carry_on(acting, {holder.logs, holder.own}, holder.view);
    EXPECT_EQ(holder.broker.session_count(), per_turn);
}

TEST(ManySessions, EachComesBackInItsOwnTime) {
    Holder holder;
    holder.logs.try_emplace(peer, peer, 100);
    const auto is_here_after = [&](std::size_t number, Duration passes) {
        holder.now += passes;
        Effects acting = holder.effects();
        holder.departures.carry_on(acting, {holder.logs, holder.own}, holder.view);
        return holder.broker.header(client(number)) != nullptr;
    };
    for (const std::size_t number : {1, 0}) {
        Effects acting = holder.effects();
        holder.departures.move(acting, client(number), peer, 1, holder.logs);
        EXPECT_FALSE(is_here_after(number, 500ms));
    }
    EXPECT_TRUE(is_here_after(1, 0ms));
    EXPECT_FALSE(is_here_after(0, 499ms));
    EXPECT_TRUE(is_here_after(0, 1ms));
}

TEST(ManySessions, OneWithOtherPredefinedTopicsGetsNone) {
    Holder holder;
    holder.logs.try_emplace(peer, peer, 100).first->second.set_foreign(true);
    holder.move_all();
    EXPECT_EQ(holder.broker.session_count(), 0U);
    EXPECT_TRUE(holder.take_written<broker::SessionMoved>().empty());
    EXPECT_TRUE(holder.departures.all().empty());
}

TEST(ManySessions, WhatIsHalfAdoptedIsNotHandedOn) {
    Holder holder;
    for (int i = 0; i < 10; ++i) {
        holder.carry_on({theirs});
        holder.now += 5ms;
    }
    EXPECT_TRUE(holder.take_written<broker::SessionMoved>().empty());
    holder.carry_on();
    holder.now += 5ms;
    holder.carry_on();
    EXPECT_FALSE(holder.take_written<broker::SessionMoved>().empty());
}

}  // namespace
}  // namespace romano::cluster::many_sessions_test
