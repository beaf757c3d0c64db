#include "overlay/cluster/ownership/hand_back.h"

#include <gtest/gtest.h>

#include "tests/overlay/cluster/events.h"
#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::hand_back_test {
namespace {

using namespace std::chrono_literals;

const LogId self = test::log_of("b1");
const LogId rival = test::log_of("b2");
const LogId other = test::log_of("b3");
const Endpoint ours = test::address(1);
const Endpoint theirs = test::address(2);

/// After a heal: broker b1 serves its own address and b2's, and so does b2.
struct AfterAHeal {
    Membership membership{ClusterOptions{}, self.broker, 1};
    ServiceAddresses addresses{{ours}};
    HandBack hand_back{self.broker, 256};
    View view{.members = {self, rival}};
    Departures departures{256};
    PeerLogs logs;
    OwnLog own{self, 100};
    broker::BrokerCore broker{test::writer_of(self), 1};
    broker::Actions clients;
    Outbox peers;
    std::vector<LocalAction> local;
    Instant now{1s};
    std::uint64_t tick = 0;

    explicit AfterAHeal(std::vector<BrokerId> heard_by_rival = {self.broker}) {
        std::ranges::sort(view.members);
        addresses.on_address(ours, true);
        addresses.on_address(theirs, true);
        hear(std::move(heard_by_rival));
    }
    void hear(std::vector<BrokerId> whom_it_hears) {
        hear(std::move(whom_it_hears), {ours, theirs});
    }
    void hear(std::vector<BrokerId> whom_it_hears, std::vector<Endpoint> serving) {
        membership.on_beacon(now, Beacon{.log = rival,
                                         .tick = ++tick,
                                         .hears = std::move(whom_it_hears),
                                         .home_addresses = {theirs},
                                         .serving = std::move(serving)});
        compare();
    }
    /// A third broker serves our address, too.
    void hear_other() {
        std::ranges::sort(view.members = {self, rival, other});
        membership.on_beacon(
            now, Beacon{.log = other, .tick = 1, .hears = {self.broker}, .serving = {ours}});
        compare();
    }
    [[nodiscard]] std::size_t handed_over(const std::set<Endpoint>& pending_output = {},
                                          const std::set<Endpoint>& half_adopted = {}) {
        clients.clear();
        Effects acting = effects();
        hand_back.carry_on(acting, {logs, own}, membership, view, addresses, departures,
                           {pending_output, half_adopted, {}});
        return clients.list().size();
    }
    void compare() {
        Effects acting = effects();
        hand_back.compare(acting, membership, view, addresses);
    }
    Effects effects() { return {now, broker, clients, peers, local, test::times}; }
    [[nodiscard]] std::size_t claimed() const { return local.size(); }
    void hear_on_for(Duration time) {
        for (const Instant end = now + time; now < end; hear({self.broker})) {
            now += 10ms;
            membership.on_tick(now);
        }
    }
    void hear_nothing_for(Duration time) {
        for (const Instant end = now + time; now < end; compare()) {
            now += 10ms;
            membership.on_tick(now);
        }
    }
};

TEST(HandBack, P3_TwoThatServeAnAddressAreBothSilent) {
    AfterAHeal healed;
    EXPECT_TRUE(healed.hand_back.is_silent(theirs));
    EXPECT_TRUE(healed.hand_back.is_silent(ours));
}

TEST(HandBack, P3_WhoIsOnlySuspectedMaySpeakStill) {
    AfterAHeal healed;
    healed.hear_nothing_for(200ms);
    ASSERT_FALSE(healed.membership.is_heard(rival.broker));
    EXPECT_TRUE(healed.hand_back.is_silent(theirs));
    EXPECT_TRUE(healed.hand_back.is_silent(ours));
    healed.view.members = {self};
    healed.compare();
    EXPECT_FALSE(healed.hand_back.is_silent(theirs));
    EXPECT_FALSE(healed.hand_back.is_silent(ours));
}

// It took the address over, because it does not hear us (simulator, seed 1042460).
TEST(HandBack, P3_WhoIsHeardOneWayMaySpeakForOurAddress) {
    AfterAHeal healed{std::vector<BrokerId>{}};
    healed.view.members = {self};
    healed.compare();
    ASSERT_FALSE(healed.membership.is_alive(rival));
    EXPECT_TRUE(healed.hand_back.is_silent(ours));
    EXPECT_TRUE(healed.hand_back.is_silent(theirs));
}

// An heir that had nothing left to hand over; the rival was heir before it (simulator, seed
// 116938).
TEST(HandBack, OnlyTheRivalsOwnWordEndsTheWaitForIt) {
    AfterAHeal healed;
    healed.hand_back.on_handed_over(test::log_of("b3").broker, ours);
    EXPECT_TRUE(healed.hand_back.is_expecting(ours));
    healed.hand_back.on_handed_over(rival.broker, ours);
    EXPECT_FALSE(healed.hand_back.is_expecting(ours));
    healed.compare();
    EXPECT_FALSE(healed.hand_back.is_expecting(ours)) << "its next beacons still name the address";
}

// P2: two of its former lives had left the address, and the heir of the second one, which held
// nothing, was the first to say so (simulator, faults `relapse`, seed 9978847).
TEST(HandBack, P2_AnOwnerWaitsForAllWhoInheritedFromIt) {
    AfterAHeal healed;
    healed.hear({self.broker}, {theirs});
    ASSERT_FALSE(healed.hand_back.is_expecting(ours));
    healed.hand_back.expect(healed.now, ours, {rival, other});
    healed.hand_back.on_handed_over(other.broker, ours);
    EXPECT_TRUE(healed.hand_back.is_expecting(ours));
    healed.hand_back.on_handed_over(rival.broker, ours);
    EXPECT_FALSE(healed.hand_back.is_expecting(ours));
}

// Its beacons come here before anything of ours gets there (simulator, seed 138174).
TEST(HandBack, NothingIsHandedToWhoDoesNotHearUsYet) {
    AfterAHeal healed;
    healed.hear({});
    EXPECT_EQ(healed.handed_over(), 0U);
    healed.now += 50ms;
    EXPECT_EQ(healed.handed_over(), 0U);
    healed.hear({self.broker});
    EXPECT_EQ(healed.handed_over(), 0U) << "what is on its way to clients leaves first";
    healed.now += 50ms;
    EXPECT_EQ(healed.handed_over(), 1U);
}

// What it is to adopt stands in our log, and a snapshot does not say that the address is sealed.
TEST(HandBack, NothingIsHandedToWhoHoldsNothingOfOurLog) {
    AfterAHeal healed;
    (void)healed.broker.adopt(healed.now,
                              std::get<broker::SessionPut>(test::session("robot", theirs)).image,
                              {}, healed.clients);
    const auto hear = [&healed](Seq holds) {
        healed.membership.on_beacon(healed.now, Beacon{.log = rival,
                                                       .tick = ++healed.tick,
                                                       .hears = {self.broker},
                                                       .applied = {{self, holds}},
                                                       .home_addresses = {theirs},
                                                       .serving = {theirs}});
        healed.compare();
    };
    hear(0);
    for (int i = 0; i < 3; ++i, healed.now += 50ms) EXPECT_EQ(healed.handed_over(), 0U);
    hear(1);
    EXPECT_EQ(healed.handed_over(), 0U) << "what is on its way to clients leaves first";
    healed.now += 50ms;
    EXPECT_EQ(healed.handed_over(), 2U) << "moved, and sealed";
}

// Who does not hear us answers there: to call its clients away from it would make them wait.
TEST(HandBack, AnOwnAddressIsClaimedWhenTheRivalHearsUs) {
    AfterAHeal healed{std::vector<BrokerId>{}};
    healed.now += 50ms;
    healed.hear({});
    EXPECT_EQ(healed.claimed(), 0U);
    healed.hear({self.broker});
    ASSERT_EQ(healed.claimed(), 1U);
    EXPECT_EQ(std::get<TakeAddress>(healed.local[0]).address, ours);
    healed.hear({self.broker});
    EXPECT_EQ(healed.claimed(), 1U) << "once is enough";
}

// A view left us out, and the rival took the address anew; the next view has us again. The address
// was bound here before that, and what clients answered to our repeats went to the rival, which was
// deaf (profile `wifi`, a broker that was struck two beacons after its return).
TEST(HandBack, P2_AnOwnAddressIsClaimedOnceInEachViewWithARival) {
    AfterAHeal healed;
    ASSERT_EQ(healed.claimed(), 1U);
    ++healed.view.number.count;
    healed.compare();
    EXPECT_EQ(healed.claimed(), 2U);
    healed.compare();
    EXPECT_EQ(healed.claimed(), 2U) << "once is enough";
}

// Its kernel asked for a client's hardware address in the name of ours, after we had claimed it:
// for a second the client's datagrams went to a machine that did not have the address any more.
TEST(HandBack, AnOwnAddressIsAnnouncedOnceMoreWhenTheRivalHasLetItGo) {
    AfterAHeal healed;
    ASSERT_EQ(healed.claimed(), 1U);
    healed.hear({self.broker}, {theirs});
    ASSERT_EQ(healed.local.size(), 2U);
    EXPECT_EQ(std::get<AnnounceAddress>(healed.local[1]).address, ours);
    healed.hear({self.broker}, {theirs});
    EXPECT_EQ(healed.local.size(), 2U) << "once is enough";
}

// It serves them, on the other side of a cut.
TEST(HandBack, NothingIsAnnouncedToClientsOfARivalThatDoesNotHearUs) {
    AfterAHeal healed{std::vector<BrokerId>{}};
    healed.hear({}, {theirs});
    EXPECT_TRUE(healed.local.empty());
}

TEST(HandBack, AnOwnAddressIsClaimedWhenTheWaitIsInVain) {
    AfterAHeal healed{std::vector<BrokerId>{}};
    healed.hear_nothing_for(2100ms);
    EXPECT_EQ(healed.claimed(), 1U);
}

// After a short cut beacons come at once, and the view when the reliable streams flow again. The
// owner spoke from its stale copy in between: QoS 2 twice (cuts of less than a second, network
// namespaces).
TEST(HandBack, P3_ARivalThatIsHeardIsWaitedForUntilItIsInOurView) {
    AfterAHeal healed;
    healed.view.members = {self};
    healed.hear_on_for(1s);
    EXPECT_TRUE(healed.hand_back.is_silent(ours));
    std::ranges::sort(healed.view.members = {self, rival});
    healed.hear_on_for(1900ms);
    EXPECT_TRUE(healed.hand_back.is_silent(ours)) << "it is about to hand over";
    healed.hear_on_for(200ms);
    EXPECT_FALSE(healed.hand_back.is_silent(ours));
}

TEST(HandBack, ARivalThatComesIntoNoViewWithUsIsWaitedForForSomeTimeOnly) {
    AfterAHeal healed;
    healed.view.members = {self};
    healed.hear_on_for(4100ms);
    EXPECT_FALSE(healed.hand_back.is_silent(ours));
}

TEST(HandBack, AnOwnAddressIsSilentForARivalForSomeTimeOnly) {
    AfterAHeal healed;
    healed.hear_nothing_for(2100ms);
    EXPECT_FALSE(healed.hand_back.is_silent(ours)) << "what the rival has does not come";
}

/// Broker b1 is back, and b2 serves both addresses.
struct Back : AfterAHeal {
    Back() {
        addresses.on_address(ours, false);
        addresses.on_address(theirs, false);
        hear({self.broker});
        local.clear();
    }
    [[nodiscard]] std::size_t bindings() {
        local.clear();
        Effects acting = effects();
        hand_back.reclaim(acting, membership, view, addresses);
        return local.size();
    }
    void on_address(bool served) {
        addresses.on_address(ours, served);
        hand_back.on_address(now, ours, served);
    }
};

TEST(HandBack, AnOwnerBindsItsAddressBesideTheHolderAndWaits) {
    Back back;
    ASSERT_EQ(back.bindings(), 1U);
    EXPECT_TRUE(back.hand_back.is_reclaiming(ours)) << "that says nothing to anybody";
    EXPECT_EQ(back.bindings(), 0U);
    back.on_address(true);
    EXPECT_FALSE(back.hand_back.is_reclaiming(ours));
    EXPECT_TRUE(back.hand_back.is_expecting(ours));
    EXPECT_EQ(back.hand_back.binding(), std::vector{ours});
    back.hand_back.on_handed_over(rival.broker, ours);
    EXPECT_TRUE(back.hand_back.binding().empty());
}

/// It has bound its address.
struct BackAndWaiting : Back {
    BackAndWaiting() {
        EXPECT_EQ(bindings(), 1U);
        on_address(true);
    }
    [[nodiscard]] bool is_expecting_after(Duration silence) {
        hear_nothing_for(silence);
        (void)handed_over();
        return hand_back.is_expecting(ours);
    }
};

// Its owner spoke some milliseconds before a view named the heir (simulator, seed 9728).
TEST(HandBack, I5_AnOwnerWaitsForAViewWithoutTheDeadGiver) {
    BackAndWaiting back;
    back.hear_on_for(1900ms);
    EXPECT_TRUE(back.is_expecting_after(400ms)) << "a living one would have been given up";
    back.view.members = {self};
    EXPECT_FALSE(back.is_expecting_after(10ms));
}

TEST(HandBack, AnOwnerGivesUpALivingGiverWhichHandsNothingOver) {
    BackAndWaiting back;
    back.hear_on_for(2050ms);
    EXPECT_FALSE(back.is_expecting_after(0ms));
}

TEST(HandBack, AnOwnerWaitsForAViewForSomeTimeOnly) {
    BackAndWaiting back;
    EXPECT_TRUE(back.is_expecting_after(3900ms));
    EXPECT_FALSE(back.is_expecting_after(200ms));
}

// The view has its former life, whose heir hands over (simulator, faults `relapse`, seeds 1271 and
// 1709).
TEST(HandBack, I5_AGiverInALaterLifeHasNotGivenWhatItHad) {
    BackAndWaiting back;
    back.membership.on_beacon(
        back.now,
        Beacon{.log = {rival.broker, rival.incarnation + 1}, .tick = 1, .hears = {self.broker}});
    EXPECT_TRUE(back.is_expecting_after(200ms));
    back.view.members = {self};
    EXPECT_FALSE(back.is_expecting_after(10ms));
}

TEST(HandBack, I1_AnOwnerSpeaksToThoseWhoHaveComeFromItsOnlyRival) {
    BackAndWaiting back;
    EXPECT_TRUE(back.hand_back.is_expecting(ours)) << "strangers wait";
    back.compare();
    EXPECT_FALSE(back.hand_back.is_silent(ours));
}

// One was the heir of its former life, and one had stood still and taken the address alone: that
// one spoke there still when the heir had handed over (simulator, faults `relapse`, seed 1041).
TEST(HandBack, I1_AnOwnerWaitsForEachOfTwoRivals) {
    Back back;
    back.hear_other();
    ASSERT_EQ(back.bindings(), 1U);
    back.on_address(true);
    back.compare();
    EXPECT_TRUE(back.hand_back.is_silent(ours));
    back.hand_back.on_handed_over(rival.broker, ours);
    EXPECT_TRUE(back.hand_back.is_silent(ours));
    back.hand_back.on_handed_over(other.broker, ours);
    EXPECT_FALSE(back.hand_back.is_silent(ours));
}

// It did not hear that the owner has it, called the hand-over off, and seals again.
TEST(HandBack, I5_ARivalThatSaysItTwiceDoesNotSpeakForTheOther) {
    Back back;
    back.hear_other();
    ASSERT_EQ(back.bindings(), 1U);
    back.on_address(true);
    back.compare();
    back.hand_back.on_handed_over(rival.broker, ours);
    back.hand_back.on_handed_over(rival.broker, ours);
    EXPECT_EQ(back.hand_back.binding(), std::vector{ours});
}

TEST(HandBack, I5_AnOwnerWaitsForThoseWhomAnEarlierViewNamedToo) {
    Back back;
    back.hand_back.expect(back.now, ours, {rival});
    back.hand_back.expect(back.now, ours, {other});
    back.hand_back.on_handed_over(rival.broker, ours);
    EXPECT_TRUE(back.hand_back.is_expecting(ours));
    back.hand_back.on_handed_over(other.broker, ours);
    EXPECT_FALSE(back.hand_back.is_expecting(ours));
}

// The heir is the owner itself, and lacks the log's last events yet.
TEST(HandBack, I5_AnOwnerThatInheritsFromItsGiverWaitsUntilItHas) {
    BackAndWaiting back;
    back.hear_nothing_for(200ms);
    back.view.members = {self};
    back.compare();
    Effects acting = back.effects();
    back.hand_back.carry_on(acting, {back.logs, back.own}, back.membership, back.view,
                            back.addresses, back.departures, {{}, {}, {ours}});
    EXPECT_TRUE(back.hand_back.is_expecting(ours));
    EXPECT_FALSE(back.is_expecting_after(10ms));
}

TEST(HandBack, I1_ARivalThatComesLaterWasNotWaitedForYet) {
    AfterAHeal healed;
    healed.hear_nothing_for(2100ms);
    ASSERT_FALSE(healed.hand_back.is_silent(ours));
    healed.membership.on_beacon(
        healed.now,
        Beacon{.log = test::log_of("b3"), .tick = 1, .hears = {self.broker}, .serving = {ours}});
    healed.compare();
    EXPECT_TRUE(healed.hand_back.is_silent(ours));
}

TEST(HandBack, I1_ARivalsWordSaysNothingOfWhatAnotherRivalHas) {
    AfterAHeal healed;
    healed.hear_other();
    healed.hand_back.on_handed_over(rival.broker, ours);
    EXPECT_TRUE(healed.hand_back.is_silent(ours));
    healed.hand_back.on_handed_over(other.broker, ours);
    EXPECT_FALSE(healed.hand_back.is_silent(ours));
}

// Some of its sessions have come from the giver; the view gives the others to a third broker.
TEST(HandBack, I5_AnOwnerWaitsForTheHeirOfAGiverThatGaveSome) {
    two_brokers::InAView back;
    const LogId giver = two_brokers::peer;
    const LogId heir = test::log_of("b3");
    const Endpoint home = two_brokers::ours;
    back.hear(0, {two_brokers::theirs, home});
    back.serve(home);
    ASSERT_TRUE(back.core.speaking().is_unheard(home)) << "its sessions are to come";
    (void)back.broker.adopt(back.now, two_brokers::image(1, home), {}, back.clients);
    back.keep_log();
    View view{.number = {200, two_brokers::self.broker, 1}, .members = {two_brokers::self, heir}};
    std::ranges::sort(view.members);
    back.take(ViewAnnouncement{
        .view = view, .assignments = {{{giver, 0}, home, heir.broker}}, .ends = {{giver, 0}}});
    ASSERT_EQ(back.core.view(), view);
    for (int i = 0; i < 12; ++i) back.pass();
    EXPECT_TRUE(back.core.speaking().is_unheard(home));
}

// After a heal: the rival was an heir of its former life, and speaks as long as the owner says that
// it waits (simulator, seeds 2758 and 15391).
TEST(HandBack, I1_AnOwnerWithSessionsOfItsOwnDoesNotSayThatItWaits) {
    two_brokers::InAView healed;
    const LogId heir = two_brokers::peer;
    const Endpoint home = two_brokers::ours;
    healed.serve(home);
    (void)healed.broker.adopt(healed.now, two_brokers::image(1, home), {}, healed.clients);
    healed.keep_log();
    healed.hear(0, {two_brokers::theirs, home});
    ASSERT_TRUE(healed.core.speaking().is_silent(home));
    const LogId former{two_brokers::self.broker, two_brokers::self.incarnation - 1};
    View view{.number = {200, two_brokers::self.broker, 1}, .members = {two_brokers::self, heir}};
    std::ranges::sort(view.members);
    healed.take(ViewAnnouncement{
        .view = view, .assignments = {{{former, 0}, home, heir.broker}}, .ends = {{former, 0}}});
    ASSERT_EQ(healed.core.view(), view);
    EXPECT_TRUE(healed.core.speaking().is_silent(home));
    EXPECT_TRUE(healed.core.beacon(healed.broker).binding.empty());
}

TEST(HandBack, WhatCannotBeBoundIsTriedAgainInTime) {
    Back back;
    ASSERT_EQ(back.bindings(), 1U);
    back.on_address(false);
    EXPECT_EQ(back.bindings(), 0U);
    back.now += 300ms;
    EXPECT_EQ(back.bindings(), 1U);
}

TEST(HandBack, NothingIsBoundBesideWhoDoesNotHearUs) {
    Back back;
    back.hear({});
    EXPECT_EQ(back.bindings(), 0U);
}

TEST(HandBack, AHolderGoesOnUntilTheOwnerHasBoundAndAnswersHaveLeft) {
    AfterAHeal holder;
    const auto hear = [&](std::vector<Endpoint> serving, std::vector<Endpoint> binding) {
        holder.membership.on_beacon(holder.now, Beacon{.log = rival,
                                                       .tick = ++holder.tick,
                                                       .hears = {self.broker},
                                                       .home_addresses = {theirs},
                                                       .serving = std::move(serving),
                                                       .binding = std::move(binding)});
        holder.compare();
    };
    hear({}, {});
    EXPECT_EQ(holder.handed_over(), 0U);
    holder.now += 50ms;
    EXPECT_EQ(holder.handed_over(), 0U) << "the owner has not bound it";
    hear({theirs}, {theirs});
    EXPECT_EQ(holder.handed_over(), 0U);
    EXPECT_FALSE(holder.hand_back.is_silent(theirs)) << "answers leave";
    holder.now += 50ms;
    EXPECT_EQ(holder.handed_over({theirs}), 0U) << "an answer waits for peers to hold it";
    EXPECT_EQ(holder.handed_over(), 1U) << "the seal";
    EXPECT_TRUE(holder.hand_back.is_silent(theirs));
    EXPECT_EQ(holder.handed_over(), 0U);
    EXPECT_TRUE(holder.addresses.is_serving(theirs)) << "the owner has not read the seal";
    hear({theirs}, {});
    EXPECT_EQ(holder.handed_over(), 0U);
    EXPECT_FALSE(holder.addresses.is_serving(theirs));
}

// Both starved in turn: the holder called it off and spoke again, and the owner adopted what was on
// its way and spoke as well (simulator, faults `starve`, seed 1767).
TEST(HandBack, I1_WhoIsOnlySuspectedMayAdoptWhatHasBegunToMove) {
    AfterAHeal holder;
    holder.membership.on_beacon(holder.now, Beacon{.log = rival,
                                                   .tick = ++holder.tick,
                                                   .hears = {self.broker},
                                                   .home_addresses = {theirs},
                                                   .serving = {theirs},
                                                   .binding = {theirs}});
    holder.compare();
    EXPECT_EQ(holder.handed_over(), 0U);
    holder.now += 50ms;
    EXPECT_EQ(holder.handed_over({}, {theirs}), 0U) << "more sessions come first";
    ASSERT_TRUE(holder.hand_back.is_silent(theirs));
    holder.hear_nothing_for(200ms);
    ASSERT_FALSE(holder.membership.is_alive(rival));
    (void)holder.handed_over({}, {theirs});
    EXPECT_TRUE(holder.hand_back.is_silent(theirs));
    holder.view.members = {self};
    (void)holder.handed_over({}, {theirs});
    EXPECT_FALSE(holder.hand_back.is_silent(theirs)) << "its log has ended";
}

}  // namespace
}  // namespace romano::cluster::hand_back_test
