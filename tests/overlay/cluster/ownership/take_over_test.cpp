#include "overlay/cluster/ownership/take_over.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::take_over_test {
namespace {

using namespace std::chrono_literals;

const LogId self = test::log_of("self");
const LogId dead = test::log_of("dead");
const LogId other = test::log_of("other");
const Endpoint theirs = test::address(9);

/// "self" inherits the address of "dead", who had the robot's session.
class TakeOverTest : public testing::Test {
protected:
    TakeOverTest() { put(dead, false); }

    PeerLog& put(const LogId& home, bool provisional) {
        PeerLog& log = peers.try_emplace(home, home, 100).first->second;
        auto session = std::get<broker::SessionPut>(test::session("robot", theirs));
        session.image.header.provisional = provisional;
        log.offer(1, {session});
        log.apply();
        return log;
    }
    std::size_t inherit(const std::vector<Assignment>& others = {}, bool may_begin = true) {
        peers.at(dead).freeze();
        TakeOver take_over{self.broker, 256};
        ViewAnnouncement view_and_heirs{.assignments = others, .ends = {{dead, 1}}};
        view_and_heirs.assignments.push_back({{dead, 1}, theirs, self.broker});
        take_over.on_view(now, view_and_heirs, addresses);
        Effects effects{now, broker, clients, outbox, local, test::times};
        take_over.carry_on(effects, {peers, own}, membership, view, addresses, departures,
                           may_begin);
        return broker.session_count();
    }

    Instant now{10s};
    broker::BrokerCore broker{test::writer_of(self), 1};
    broker::Actions clients;
    Outbox outbox;
    std::vector<LocalAction> local;
    PeerLogs peers;
    OwnLog own{self, 100};
    Membership membership{ClusterOptions{}, self.broker, 1};
    ServiceAddresses addresses{{}};
    Departures departures{256};
    View view{.members = {self}};
};

TEST_F(TakeOverTest, AnHeirAdopts) {
    EXPECT_EQ(inherit(), 1U);
}

// The next view's leader may give the address to somebody else (model/speak.pml,
// adopt-below-the-promise).
TEST_F(TakeOverTest, I1_WhoHasPromisedAnotherViewBeginsNothing) {
    EXPECT_EQ(inherit({}, false), 0U);
    EXPECT_FALSE(addresses.is_taking(theirs));
    EXPECT_EQ(inherit(), 1U);
}

// P3: what the view agreed on and is not here yet was said to clients.
TEST_F(TakeOverTest, AnHeirGoesOnWhenItHoldsTheAgreedEnd) {
    PeerLog& log = peers.at(dead);
    log.freeze();
    log.end_at(2, {.term = 2});
    EXPECT_EQ(inherit(), 0U);
    log.offer(2, {test::published(dead, 2)});
    log.apply();
    EXPECT_EQ(inherit(), 1U);
}

// An earlier life of the dead one left it the address; the heir, who holds what the later life
// wrote, took it as well (simulator, faults `relapse`, seed 39).
TEST_F(TakeOverTest, I1_WhereAMemberAnswersAlreadyNobodyElseTakesTheAddress) {
    view.members.push_back(other);
    Beacon server{.log = other, .tick = 1, .hears = {self.broker}};
    server.serving = {theirs};
    (void)membership.on_beacon(now, server);
    EXPECT_EQ(inherit(), 0U);
    EXPECT_FALSE(addresses.is_taking(theirs));
    ASSERT_TRUE(departures.all().contains("robot"));
    EXPECT_EQ(departures.all().at("robot").session.to, other);
    const auto& sealed = std::get<broker::Append>(clients.list().back());
    EXPECT_EQ(std::get<broker::Sealed>(*sealed.event).address, theirs);
}

// Its copy may be the older one: it would begin what the other heir's has begun already (simulator,
// faults `relapse`, seed 9870835).
TEST_F(TakeOverTest, P3_TheFirstHeirIsSilentUntilTheOthersHavePassedOnTheirs) {
    view.members.push_back(other);
    const auto in_view = [&](const Assignment& first, const Assignment& second) {
        peers.at(dead).freeze();
        TakeOver take_over{self.broker, 256};
        take_over.on_view(now, {.view = view, .assignments = {first, second}}, addresses);
        return take_over;
    };
    const auto carry_on = [&](TakeOver& take_over) {
        Effects effects{now, broker, clients, outbox, local, test::times};
        take_over.carry_on(effects, {peers, own}, membership, view, addresses, departures, true);
    };
    const auto give_up_all = [&] {
        Effects effects{now, broker, clients, outbox, local, test::times};
        addresses.give_up_all(effects);
    };
    const Assignment ours{{dead, 1}, theirs, self.broker};
    const Assignment to_other{{test::log_of("third"), 1}, theirs, other.broker};
    EXPECT_FALSE(in_view(to_other, ours).awaits_heirs(theirs)) << "it is the other one's";

    TakeOver take_over = in_view(ours, to_other);
    carry_on(take_over);
    EXPECT_EQ(broker.session_count(), 1U) << "it adopts";
    EXPECT_TRUE(take_over.awaits_heirs(theirs));
    take_over.on_handed_over(dead.broker, theirs);
    carry_on(take_over);
    EXPECT_TRUE(take_over.awaits_heirs(theirs)) << "that was somebody else";
    take_over.on_handed_over(other.broker, theirs);
    carry_on(take_over);
    EXPECT_FALSE(take_over.awaits_heirs(theirs));

    EXPECT_FALSE(in_view(ours, to_other).awaits_heirs(theirs)) << "it is spoken from already";
    give_up_all();
    TakeOver impatient = in_view(ours, to_other);
    now += test::times.other_heirs_waited_for() + 1ms;
    carry_on(impatient);
    EXPECT_FALSE(impatient.awaits_heirs(theirs)) << "it has waited long enough";

    give_up_all();
    TakeOver bereft = in_view(ours, to_other);
    bereft.on_view(now, {.view = {.members = {self}}, .assignments = {ours}}, addresses);
    carry_on(bereft);
    EXPECT_FALSE(bereft.awaits_heirs(theirs)) << "that one died, too";
}

// Its machine may not be able to serve it.
TEST_F(TakeOverTest, P1_AnAddressIsLeftToItsHeirUntilThatMustHaveBegun) {
    TakeOver take_over{self.broker, 256};
    const View both{.members = {self, other}};
    take_over.on_view(now, {.view = both, .assignments = {{{dead, 1}, theirs, other.broker}}},
                      addresses);
    const auto is_left = [&] {
        Effects effects{now, broker, clients, outbox, local, test::times};
        take_over.carry_on(effects, {peers, own}, membership, both, addresses, departures, true);
        return take_over.is_left_to_another(theirs);
    };
    now += test::times.other_heirs_waited_for();
    EXPECT_TRUE(is_left());
    now += 1ms;
    EXPECT_FALSE(is_left());
}

// Two dead lives of one broker left it, and no member held both logs: each had an heir, and both
// took the address (simulator, faults `relapse`, seed 366).
TEST_F(TakeOverTest, I1_AnAddressThatSeveralInheritIsTheFirstHeirs) {
    view.members.push_back(other);
    const Assignment to_other{{test::log_of("third"), 1}, theirs, other.broker};
    EXPECT_EQ(inherit({to_other}), 0U);
    EXPECT_FALSE(addresses.is_taking(theirs));
    EXPECT_TRUE(departures.all().empty()) << "it does not serve it yet";
    Beacon server{.log = other, .tick = 1, .hears = {self.broker}};
    server.serving = {theirs};
    (void)membership.on_beacon(now, server);
    EXPECT_EQ(inherit({to_other}), 0U);
    EXPECT_FALSE(addresses.is_taking(theirs));
    EXPECT_TRUE(departures.all().contains("robot")) << "it goes there";
}

// P8: the peer was forgotten, for there are too many.
TEST_F(TakeOverTest, ADeadBrokerOfWhichNothingIsKnownMayStillBeHeard) {
    (void)membership.on_beacon(now, {.log = dead, .tick = 1});
    for (int i = 0; membership.find(dead.broker) != nullptr; ++i) {
        ASSERT_LT(i, 2'000);
        const LogId another = test::log_of("another" + std::to_string(i));
        (void)membership.on_beacon(now, {.log = another, .tick = 1});
    }
    ASSERT_TRUE(membership.is_heard(dead.broker));
    EXPECT_EQ(inherit(), 1U);
}

// Its machine cannot.
TEST_F(TakeOverTest, P2_WhatTheFirstHeirNeverServesIsAdoptedWithoutTheAddress) {
    peers.at(dead).freeze();
    TakeOver take_over{self.broker, 256};
    const Assignment to_other{{test::log_of("third"), 1}, theirs, other.broker};
    take_over.on_view(now, {.assignments = {to_other, {{dead, 1}, theirs, self.broker}}},
                      addresses);
    now += test::times.giver_waited_for() + 1ms;
    Effects effects{now, broker, clients, outbox, local, test::times};
    take_over.carry_on(effects, {peers, own}, membership, view, addresses, departures, true);
    EXPECT_EQ(broker.session_count(), 1U);
    EXPECT_FALSE(addresses.is_taking(theirs));
}

// Of that one the own log would say that it is gone.
TEST_F(TakeOverTest, I7_WhatTheDeadHadIsJoinedWithTheOwnSessionAndNotPassedOn) {
    auto session = std::get<broker::SessionPut>(test::session("robot", test::address(1)));
    session.image.header.epoch = 5;
    (void)broker.adopt(now, session.image, {}, clients);
    view.members.push_back(other);
    Beacon server{.log = other, .tick = 1, .hears = {self.broker}};
    server.serving = {theirs};
    server.applied = {{self, broker.last_seq()}};
    (void)membership.on_beacon(now, server);
    EXPECT_EQ(inherit(), 1U);
    EXPECT_TRUE(peers.at(dead).clients_left(theirs).empty()) << "it was looked at";
    EXPECT_EQ(broker.header("robot")->epoch, 5U);
    EXPECT_TRUE(departures.all().empty());
}

// The dead one lives again and serves its address, while the heir still binds it: sealed for that
// one, it would be spoken from here as soon as it is bound (simulator, as shipped, seed 1767).
TEST_F(TakeOverTest, I1_AnHeirThatTakesTheAddressItselfPassesNothingOn) {
    view.members.push_back(other);
    Beacon server{.log = other, .tick = 1, .hears = {self.broker}};
    server.serving = {theirs};
    (void)membership.on_beacon(now, server);
    Effects taking{now, broker, clients, outbox, local, test::times};
    addresses.take(taking, theirs);
    EXPECT_EQ(inherit(), 1U);
    EXPECT_TRUE(departures.all().empty());
    for (const broker::Action& action : clients.list()) {
        const auto* said = std::get_if<broker::Append>(&action);
        EXPECT_FALSE(said != nullptr && std::holds_alternative<broker::Sealed>(*said->event));
    }
}

// P3: the later one was the lower one, and took the place of the other in our log (simulator,
// faults `relapse`, seed 261).
TEST_F(TakeOverTest, P3_OfTwoDeadCopiesTheHigherOneIsPassedOn) {
    for (const std::uint64_t epoch : {2, 1}) {
        auto session = std::get<broker::SessionPut>(test::session("robot", theirs));
        session.image.header.epoch = epoch;
        Effects effects{now, broker, clients, outbox, local, test::times};
        departures.pass_on(effects, {peers, own}, session.image, other);
    }
    ASSERT_TRUE(departures.all().contains("robot"));
    EXPECT_EQ(departures.all().at("robot").session.image.header.epoch, 2U);
    const auto& moved = std::get<broker::Append>(clients.list().back());
    EXPECT_EQ(std::get<broker::SessionMoved>(*moved.event).header.epoch, 2U);
}

// Readers take it for as far worked through as its passer is. What had left before was that far
// then (simulator, as shipped, seed 11222).
TEST_F(TakeOverTest, P2_WhatWasPublishedSinceTheHigherCopyLeftGoesWithIt) {
    const LogId writer = test::log_of("writer");
    PeerLog& log = peers.try_emplace(writer, writer, 100).first->second;
    for (const std::uint64_t epoch : {2, 1}) {
        auto session = std::get<broker::SessionPut>(test::session("robot", theirs));
        session.image.header.epoch = epoch;
        session.image.header.clean = false;
        session.image.subscriptions = {{.filter = "pose", .granted = mqttsn::Qos::at_least_once}};
        Effects effects{now, broker, clients, outbox, local, test::times};
        departures.pass_on(effects, {peers, own}, session.image, other);
        const broker::LogEvent event = test::published(writer, 1);
        log.offer(1, {event});
        if (log.has_next()) log.apply();
        broker.on_peer_message(now, std::get<broker::Published>(event).message, clients);
    }
    ASSERT_TRUE(departures.all().contains("robot"));
    const broker::SessionImage& left = departures.all().at("robot").session.image;
    EXPECT_EQ(left.header.epoch, 2U);
    EXPECT_EQ(left.deliveries.size(), 1U);
    EXPECT_EQ(broker::worked_through(left, writer), 1U);
}

// It waits to be adopted there.
TEST_F(TakeOverTest, P2_WhatTheDeadHadMovedToAMemberIsLeftToThatOne) {
    view.members.push_back(other);
    std::ranges::sort(view.members);
    peers.at(dead).offer(2, {test::moved(test::session("robot", theirs), other)});
    peers.at(dead).apply();
    EXPECT_EQ(inherit(), 0U);
}

TEST_F(TakeOverTest, P2_WhatTheDeadHadMovedToNobodyIsTheHeirs) {
    peers.at(dead).offer(2, {test::moved(test::session("robot", theirs), other)});
    peers.at(dead).apply();
    EXPECT_EQ(inherit(), 1U);
}

// Its heir serves the address already; the other one, to which the session was moved, died next.
TEST_F(TakeOverTest, P2_WhatMayHaveArrivedAtAnotherDeadOneIsWaitedFor) {
    peers.at(dead).offer(2, {test::moved(test::session("robot", theirs), other)});
    peers.at(dead).apply();
    peers.at(dead).freeze();
    addresses.on_address(theirs, true);
    PeerLog& last_words = peers.try_emplace(other, other, 100).first->second;
    last_words.freeze();
    last_words.end_at(1, {.term = 1});
    TakeOver take_over{self.broker, 256};
    take_over.on_view(now, {.assignments = {{{dead, 2}, theirs, self.broker}}}, addresses);
    Effects effects{now, broker, clients, outbox, local, test::times};
    const auto carry_on = [&] {
        take_over.carry_on(effects, {peers, own}, membership, view, addresses, departures, true);
        return broker.session_count();
    };
    EXPECT_EQ(carry_on(), 0U);
    last_words.offer(1, {test::session("another")});
    last_words.apply();
    EXPECT_EQ(carry_on(), 1U) << "it did not arrive";
}

TEST_F(TakeOverTest, ACopyThatOutranksTheDeadOnesStays) {
    peers.clear();
    put(dead, true);
    put(other, false);
    EXPECT_EQ(inherit(), 0U);
}

// It was adopted from there; whoever holds both logs knows, and does not adopt the former one
// (simulator, seed 2110352).
TEST_F(TakeOverTest, P2_ACopyInAnotherDeadLogDoesNot) {
    peers.clear();
    put(dead, true);
    put(other, false).freeze();
    EXPECT_EQ(inherit(), 1U);
}

TEST_F(TakeOverTest, ACopyThatIsOutrankedDoesNot) {
    put(other, true);
    EXPECT_EQ(inherit(), 1U);
}

TEST_F(TakeOverTest, P3_FromAnOutdatedLogItTakesNothingBeforeItHearsTheMembers) {
    peers.at(dead).become_outdated();
    view.members.push_back(other);
    EXPECT_EQ(inherit(), 0U);
    put(other, true);
    (void)membership.on_beacon(now, {.log = other, .last_seq = 2, .tick = 1, .view = view});
    EXPECT_EQ(inherit(), 0U) << "it lacks an event";
    peers.at(other).offer(2, {test::erased("robot")});
    peers.at(other).apply();
    EXPECT_EQ(inherit(), 1U);
}

// It may be about to adopt the session from a later home of it (simulator, faults `relapse`, seed
// 9881270).
TEST_F(TakeOverTest, P3_FromAnOutdatedLogItTakesNothingBeforeTheOtherHeirsServe) {
    const Endpoint another = test::address(8);
    const Assignment to_other{{test::log_of("third"), 1}, another, other.broker};
    peers.at(dead).become_outdated();
    view.members.push_back(other);
    peers.try_emplace(other, other, 100);
    (void)membership.on_beacon(now, {.log = other, .tick = 1, .view = view});
    EXPECT_EQ(inherit({to_other}), 0U);
    (void)membership.on_beacon(now, {.log = other, .tick = 2, .view = view, .serving = {another}});
    EXPECT_EQ(inherit({to_other}), 1U);
}

TEST_F(TakeOverTest, ButOfItsOwnAddressTheFirstHeirDoesNotWaitForAnother) {
    const Assignment also_other{{test::log_of("third"), 1}, theirs, other.broker};
    peers.at(dead).become_outdated();
    EXPECT_EQ(inherit({{{dead, 1}, theirs, self.broker}, also_other}), 1U);
}

// P3: its own broker is back, and would take the empty hand for all that there is.
TEST_F(TakeOverTest, WhatWasDoneBeforeTheViewIsNotHandedOnToTheOwner) {
    view.members.push_back(other);
    Beacon back{.log = other, .tick = 1, .hears = {self.broker}};
    back.home_addresses = back.serving = {theirs};
    (void)membership.on_beacon(now, back);
    addresses.on_address(theirs, true);
    peers.at(dead).freeze();
    peers.at(dead).mark_taken(broker::ClientId{"robot"});
    EXPECT_EQ(inherit(), 0U);
    EXPECT_TRUE(clients.list().empty()) << "no seal";
}

// Whoever has the session went on from what the outdated log ended with: to take it from there
// again would be to say everything since then twice (simulator, fault `starve`, seed 201).
TEST_F(TakeOverTest, P3_FromAnOutdatedLogItTakesWhatNobodyElseHas) {
    peers.at(dead).become_outdated();
    EXPECT_EQ(inherit(), 1U);
}

TEST_F(TakeOverTest, P3_AndNothingElse) {
    peers.at(dead).become_outdated();
    put(other, true);
    EXPECT_EQ(inherit(), 0U);
}

}  // namespace
}  // namespace romano::cluster::take_over_test
