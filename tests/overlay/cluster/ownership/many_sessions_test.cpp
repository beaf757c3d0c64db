// Thousands of sessions move in pieces: a broker that adopted all of them at once would be late for
// its peers. Until all are there nobody is a stranger, and nothing is said twice.
#include <gtest/gtest.h>

#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::many_sessions_test {
namespace {

using namespace two_brokers;
using namespace std::chrono_literals;

constexpr std::size_t sessions = 600;
constexpr std::size_t per_turn = 256;

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
    for (int i = 0; i < 100 && heir.broker.session_count() == 0; ++i) heir.pass();
    ASSERT_EQ(heir.broker.session_count(), per_turn) << "the first ones when the peer is dead";
    heir.serve(theirs);
    while (heir.broker.session_count() < sessions) {
        ASSERT_EQ(heir.core.next_wakeup(), Instant::min());
        EXPECT_TRUE(heir.core.must_wait(theirs, test::address(99))) << "no stranger yet";
        EXPECT_FALSE(heir.core.must_wait(ours, test::address(99)));
        const std::size_t before = heir.broker.session_count();
        heir.take(LogAck{});  // any other input
        ASSERT_EQ(heir.broker.session_count(), before);
        heir.tick();
        ASSERT_GT(heir.broker.session_count(), before);
        ASSERT_LE(heir.broker.session_count(), before + per_turn);
    }
    heir.tick();
    EXPECT_GT(heir.core.next_wakeup(), heir.now);
    EXPECT_FALSE(heir.core.must_wait(theirs, test::address(99)));
}

/// "self" serves the address of "peer", which is back and serves it as well.
struct Holder : Owner {
    Membership membership{ClusterOptions{}, self.broker, 1};
    ServiceAddresses addresses{{ours}};
    HandBack hand_back{self.broker, per_turn};
    View view{.members = {self, peer}};

    Holder() {
        std::ranges::sort(view.members);
        addresses.on_address(ours, true);
        addresses.on_address(theirs, true);
        membership.on_beacon(now, Beacon{.log = peer,
                                         .tick = 1,
                                         .hears = {self.broker},
                                         .home_addresses = {theirs},
                                         .serving = {theirs}});
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
            acting, membership, view, addresses,
            {.pending_output = {}, .half_adopted = half_adopted, .inheriting = inheriting});
    }
    void acknowledge() {
        Effects acting = effects();
        hand_back.on_ack(acting, peer.broker, HandoffAck{.address = theirs}, addresses);
    }
};

TEST(ManySessions, TheyAreHandedBackAndForgottenInPieces) {
    Holder holder;
    holder.carry_on();
    holder.now += 5ms;
    std::size_t sent = 0;
    for (bool last = false; !last;) {
        holder.carry_on();
        EXPECT_TRUE(holder.hand_back.is_silent(theirs));
        std::size_t in_turn = 0;
        for (const SessionHandoff& part : holder.take_sent<SessionHandoff>()) {
            in_turn += part.sessions.size();
            last = part.last;
        }
        ASSERT_GT(in_turn, 0U);
        ASSERT_LE(in_turn, per_turn);
        sent += in_turn;
        EXPECT_EQ(holder.hand_back.is_half_done(), !last);
        if (!last) holder.acknowledge();  // of an earlier hand-over that was called off
        EXPECT_EQ(holder.broker.session_count(), sessions);
    }
    EXPECT_EQ(sent, sessions);

    holder.acknowledge();
    for (std::size_t left = sessions - per_turn;; left -= std::min(left, per_turn)) {
        EXPECT_EQ(holder.broker.session_count(), left);
        EXPECT_EQ(holder.addresses.is_serving(theirs), left > 0);
        EXPECT_EQ(holder.hand_back.is_half_done(), left > 0);
        if (left == 0) break;
        EXPECT_TRUE(holder.hand_back.is_deaf(theirs));
        holder.carry_on();
    }
}

// What it said for them comes first, from its log (simulator, seed 811931).
TEST(ManySessions, P3_ThoseThatTheOwnerMayHaveSpokenForAreSilentUntilItsHeirHasThem) {
    Holder holder;
    holder.carry_on();
    holder.now += 5ms;
    do {
        holder.carry_on();
    } while (holder.hand_back.is_half_done());
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

// P3: it had sent them what waits here, too. The heir has that from its log (simulator, faults
// `relapse`, seed 9872321).
TEST(ManySessions, P3_ThoseThatTheOwnerMayHaveSpokenForAreSilentUntilAnotherHeirHandsThemOver) {
    Holder holder;
    holder.carry_on();
    holder.now += 5ms;
    do {
        holder.carry_on();
    } while (holder.hand_back.is_half_done());
    const LogId heir = test::log_of("third");
    ASSERT_LT(heir.broker, self.broker) << "the address stays here";
    (void)holder.membership.on_beacon(holder.now, {.log = heir, .tick = 1, .hears = {self.broker}});
    (void)holder.membership.on_beacon(holder.now, {.log = peer, .tick = 2, .leaving = true});
    holder.view.members = {heir, self};
    holder.hand_back.on_view(
        {.view = holder.view, .assignments = {{{peer, 7}, theirs, heir.broker}}, .ends = {}});
    Effects acting = holder.effects();
    holder.hand_back.compare(acting, holder.membership, holder.view, holder.addresses);
    holder.carry_on();
    EXPECT_TRUE(holder.hand_back.is_silent(theirs));
    holder.hand_back.on_handed_over(heir.broker, theirs);
    holder.carry_on();
    EXPECT_FALSE(holder.hand_back.is_silent(theirs));
}

// Its heir, perhaps we, goes on from its copies.
TEST(ManySessions, NoneIsLeftWhenTheOwnerDiesBeforeAllAreForgotten) {
    Holder holder;
    holder.carry_on();
    holder.now += 5ms;
    for (int i = 0; i < 3; ++i) holder.carry_on();
    holder.acknowledge();
    EXPECT_EQ(holder.broker.session_count(), sessions - per_turn);
    Effects acting = holder.effects();
    holder.hand_back.forget_for_the_dead(acting, holder.view, holder.addresses);
    EXPECT_EQ(holder.broker.session_count(), sessions - per_turn) << "it lives";
    holder.view.members = {self};
    holder.hand_back.forget_for_the_dead(acting, holder.view, holder.addresses);
    EXPECT_EQ(holder.broker.session_count(), 0U);
    EXPECT_FALSE(holder.addresses.is_serving(theirs));
    EXPECT_FALSE(holder.hand_back.is_half_done());
}

TEST(ManySessions, WhatIsHalfAdoptedIsNotHandedOn) {
    Holder holder;
    for (int i = 0; i < 10; ++i) {
        holder.carry_on({theirs});
        holder.now += 5ms;
    }
    EXPECT_TRUE(holder.take_sent<SessionHandoff>().empty());
    holder.carry_on();
    holder.now += 5ms;
    holder.carry_on();
    EXPECT_FALSE(holder.take_sent<SessionHandoff>().empty());
}

}  // namespace
}  // namespace romano::cluster::many_sessions_test
