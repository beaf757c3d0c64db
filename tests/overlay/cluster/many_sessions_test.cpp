// Thousands of sessions move in pieces: a broker that adopted all of them at once would be late for
// its peers. Until all are there nobody is a stranger, and nothing is said twice.
#include <gtest/gtest.h>

#include "overlay/cluster/cluster_core.h"
#include "tests/overlay/cluster/events.h"

namespace romano::cluster {
namespace {

using namespace std::chrono_literals;

const LogId self = test::log_of("self");
const LogId peer = test::log_of("peer");
const Endpoint ours = test::address(1);
const Endpoint theirs = test::address(2);
constexpr std::size_t sessions = 600;
constexpr std::size_t per_turn = 256;

std::string client(std::size_t number) {
    return "robot" + std::to_string(number);
}

broker::SessionImage image(std::size_t number, const Endpoint& via) {
    return std::get<broker::SessionPut>(test::session(client(number), via)).image;
}

/// A broker core and who lends it to the cluster's parts.
struct Owner {
    Instant now{10s};
    broker::BrokerCore broker{test::writer_of(self), 1};
    broker::Actions clients;
    Outbox peers;
    std::vector<LocalAction> local;

    [[nodiscard]] Effects effects() { return {now, broker, clients, peers, local}; }
    void adopt_all(const Endpoint& via) {
        for (std::size_t i = 0; i < sessions; ++i) {
            (void)broker.adopt(now, image(i, via), {}, clients);
        }
    }
    template <typename Kind>
    [[nodiscard]] std::vector<Kind> take_sent() {
        std::vector<Kind> sent;
        for (auto& outgoing : peers) {
            if (auto* message = std::get_if<Kind>(&outgoing.message)) {
                sent.push_back(std::move(*message));
            }
        }
        peers.clear();
        return sent;
    }
};

/// Broker "self", and what it knows of "peer".
struct Cluster : Owner {
    ClusterCore core{ClusterOptions{}, {.name = "self", .log = self, .home_addresses = {ours}}, 1};
    std::uint64_t ticks = 0;

    void keep_log() {
        for (broker::Action& action : clients.list()) {
            if (auto* append = std::get_if<broker::Append>(&action)) {
                core.append(append->seq, std::move(*append->event));
            }
        }
        clients.clear();
    }
    void take(ClusterMessage message) {
        Effects acting = effects();
        core.on_message(acting, {peer, std::move(message)});
        keep_log();
    }
    void tick() {
        Effects acting = effects();
        core.on_tick(acting, {});
        keep_log();
    }
    void serve(const Endpoint& address) {
        Effects acting = effects();
        core.on_address(acting, address, true);
        keep_log();
    }
    /// Time goes on by a beacon's interval.
    void pass() {
        now += 10ms;
        tick();
    }
    void hear() {
        now += 10ms;
        take(Beacon{.name = "peer",
                    .log = peer,
                    .last_seq = sessions,
                    .tick = ++ticks,
                    .hears = {self.broker},
                    .home_addresses = {theirs},
                    .serving = {theirs}});
        tick();
    }
};

TEST(ManySessions, AnHeirAdoptsThemInPieces) {
    Cluster heir;
    heir.serve(ours);
    for (int i = 0; i < 5; ++i) heir.hear();
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

/// "self" gets sessions from a live home.
struct NewHome : Owner {
    PeerLogs nobody;
    OwnLog own{self, 10'000};
    Logs logs{nobody, own};
    HandoffReceiver receiver{per_turn};
};

TEST(ManySessions, ANewHomeAdoptsThemInPiecesAndAcknowledgesAll) {
    NewHome home;
    SessionHandoff all{.address = ours, .last = true};
    for (std::size_t i = 0; i < sessions; ++i) all.sessions.push_back(image(i, ours));
    Effects acting = home.effects();
    home.receiver.on_handoff(acting, home.logs, peer.broker, std::move(all));
    for (std::size_t adopted = per_turn; adopted < sessions; adopted += per_turn) {
        EXPECT_EQ(home.broker.session_count(), adopted);
        EXPECT_TRUE(home.receiver.is_half_done());
        EXPECT_TRUE(home.receiver.take_adopted().empty());
        home.receiver.carry_on(acting, home.broker.last_seq());
        EXPECT_TRUE(home.take_sent<HandoffAck>().empty());
        home.receiver.on_turn(acting, home.logs);
    }
    EXPECT_EQ(home.broker.session_count(), sessions);
    EXPECT_FALSE(home.receiver.is_half_done());
    ASSERT_EQ(home.receiver.take_adopted().size(), 1U);
    home.receiver.carry_on(acting, home.broker.last_seq() - 1);
    EXPECT_TRUE(home.take_sent<HandoffAck>().empty()) << "the last one is not safe yet";
    home.receiver.carry_on(acting, home.broker.last_seq());
    EXPECT_EQ(home.take_sent<HandoffAck>().size(), 1U);
}

// It waited in a process that stood still and was replaced; meanwhile the sessions lived on
// (simulator, fault `stop`, acks all, seed 167).
TEST(ManySessions, P3_WhatWasHandedToAFormerLifeIsNotAdopted) {
    Cluster home;
    home.hear();
    const auto hand_over = [&](const LogId& to) {
        SessionHandoff all{.to = to, .address = ours, .last = true};
        all.sessions.push_back(image(0, ours));
        home.take(std::move(all));
        return home.broker.session_count();
    };
    EXPECT_EQ(hand_over(test::log_of("self", 0)), 0U);
    EXPECT_EQ(hand_over(self), 1U);
}

// They may have lived on elsewhere since; whoever asks asks again.
TEST(ManySessions, P4_WhoMayHaveBeenReplacedGivesNoneAway) {
    Cluster home;
    home.hear();
    (void)home.broker.adopt(home.now, image(0, ours), {}, home.clients);
    home.keep_log();
    home.core.listen_only(100ms);
    home.take(SessionRequest{client(0)});
    EXPECT_TRUE(home.take_sent<SessionHandoff>().empty());
    home.core.resume(home.now);
    home.take(SessionRequest{client(0)});
    EXPECT_EQ(home.take_sent<SessionHandoff>().size(), 1U);
}

TEST(ManySessions, AHandOverThatLacksAPartIsNotAcknowledged) {
    NewHome home;
    Effects acting = home.effects();
    const auto take = [&](std::uint32_t part, std::size_t number, bool last) {
        SessionHandoff message{.address = ours, .part = part, .last = last};
        message.sessions.push_back(image(number, ours));
        home.receiver.on_handoff(acting, home.logs, peer.broker, std::move(message));
        home.receiver.carry_on(acting, home.broker.last_seq());
    };
    take(0, 1, false);
    take(2, 3, true);
    take(3, 4, true);
    EXPECT_EQ(home.broker.session_count(), 0U);
    EXPECT_TRUE(home.take_sent<HandoffAck>().empty());
    take(0, 1, false);
    take(0, 1, false);  // begun anew once more
    take(1, 2, true);
    EXPECT_EQ(home.broker.session_count(), 2U);
    EXPECT_EQ(home.take_sent<HandoffAck>().size(), 1U);
}

/// "self" serves the address of "peer", which is back and serves it as well.
struct Holder : Owner {
    Membership membership{ClusterOptions{}, self.broker, 1};
    ServiceAddresses addresses{{ours}};
    HandBack hand_back{self.broker, 100ms, per_turn};
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
        adopt_all(theirs);
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
}  // namespace romano::cluster
