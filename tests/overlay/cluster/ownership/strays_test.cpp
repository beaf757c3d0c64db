#include "overlay/cluster/ownership/strays.h"

#include <gtest/gtest.h>

#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::strays_test {
namespace {

using namespace two_brokers;

constexpr std::size_t sessions = 80;
constexpr std::size_t per_turn = 32;

/// "self" has adopted sessions of the peer's address, which its machine does not serve.
struct StraysTest : testing::Test, Owner {
    StraysTest() {
        std::ranges::sort(view.members);
        for (std::size_t i = 0; i < sessions; ++i) {
            (void)broker.adopt(now, image(i, theirs), {}, clients);
        }
        (void)broker.adopt(now, image(sessions, ours), {}, clients);
        clients.clear();
        addresses.on_address(ours, true);
        addresses.on_adopted(theirs);
    }
    void hear(std::vector<Endpoint> serving, std::vector<Endpoint> binding = {}) {
        membership.on_beacon(now, Beacon{.log = peer,
                                         .tick = ++tick,
                                         .hears = {self.broker},
                                         .applied = {{self, 1}},
                                         .home_addresses = {theirs},
                                         .serving = std::move(serving),
                                         .binding = std::move(binding)});
    }
    std::size_t carry_on(const std::set<Endpoint>& half_adopted = {}) {
        Effects acting = effects();
        strays.carry_on(acting, {logs, own}, membership, view, addresses, departures, half_adopted);
        return departures.to(peer);
    }
    void arrive() {
        for (const auto& [name, leaving] : std::map{departures.all()}) {
            departures.on_arrived(name, leaving.session.at);
        }
    }

    Membership membership{ClusterOptions{}, self.broker, 1};
    ServiceAddresses addresses{{ours}};
    Departures departures{per_turn};
    PeerLogs logs;
    OwnLog own{self, 100};
    View view{.members = {self, peer}};
    Strays strays{per_turn};
    std::uint64_t tick = 0;
};

// Those that only listen would hear nothing (simulator, --unable, seed 96).
TEST_F(StraysTest, P2_TheyGoToWhoServesTheirAddressInPieces) {
    EXPECT_EQ(carry_on(), 0U) << "nobody serves it";
    hear({theirs});
    EXPECT_EQ(carry_on({theirs}), 0U) << "more are to be adopted";
    EXPECT_EQ(carry_on(), per_turn);
    EXPECT_EQ(carry_on(), 2 * per_turn);
    EXPECT_EQ(carry_on(), 2 * per_turn) << "enough are on their way";
    arrive();
    EXPECT_EQ(carry_on(), sessions - 2 * per_turn);
    EXPECT_EQ(broker.session_count(), 1U);
    EXPECT_TRUE(addresses.adopted().contains(theirs)) << "they may come back";
    arrive();
    EXPECT_EQ(carry_on(), 0U);
    EXPECT_FALSE(addresses.adopted().contains(theirs));
}

TEST_F(StraysTest, P2_ThoseThatNobodyAnswersForComeBackAndGoAgain) {
    hear({theirs});
    logs.try_emplace(peer, peer, 100);
    for (int i = 0; i < 2; ++i) (void)carry_on();
    arrive();
    ASSERT_EQ(carry_on(), sessions - 2 * per_turn);
    now += test::times.handover_acknowledged_within();
    Effects acting = effects();
    departures.carry_on(acting, {logs, own}, view);
    ASSERT_EQ(broker.session_count(), 1 + sessions - 2 * per_turn);
    EXPECT_EQ(carry_on(), sessions - 2 * per_turn);
    EXPECT_TRUE(addresses.adopted().contains(theirs));
}

TEST_F(StraysTest, WhoWaitsForSessionsThereIsGivenThemByItsGiver) {
    hear({theirs}, {theirs});
    EXPECT_EQ(carry_on(), 0U);
}

TEST_F(StraysTest, WhatIsServedHereStays) {
    hear({theirs});
    addresses.on_address(theirs, true);
    EXPECT_EQ(carry_on(), 0U);
    EXPECT_FALSE(addresses.adopted().contains(theirs));
}

TEST_F(StraysTest, OneThatWasFetchedMeanwhileIsNotMoved) {
    hear({theirs});
    (void)carry_on();
    arrive();
    Effects acting = effects();
    const auto still_here = broker.client_ids_via(theirs);
    ASSERT_FALSE(still_here.empty());
    departures.move(acting, still_here.front(), test::log_of("third"), 1, logs);
    while (departures.to(peer) < sessions - per_turn - 1) {
        const std::size_t before = departures.to(peer);
        ASSERT_GT(carry_on(), before);
    }
    EXPECT_EQ(departures.to(test::log_of("third")), 1U);
}

}  // namespace
}  // namespace romano::cluster::strays_test
