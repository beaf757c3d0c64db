// What a leader asks, concludes and says.
#include "tests/overlay/cluster/agreement/leader_and_peers.h"

namespace romano::cluster::view_change_test {
namespace {

TEST(ViewChange, AProposalThatCameToNothingLeavesNoLogFrozen) {
    Leader leader;
    leader.begin();
    // The peer is missed while another one has just come; that one then takes the lead, and dies.
    leader.hear(high, self, leader.term(), 9);
    leader.membership.on_left_out(leader.now, peer);
    leader.wait(10ms);
    ASSERT_TRUE(leader.logs.at(peer).is_frozen());
    leader.hear(high, high, leader.term() + 1, 9);
    leader.hear(peer, high, leader.term() + 1, 1);
    leader.wait(10ms);
    ASSERT_FALSE(leader.membership.leads());
    leader.membership.on_left_out(leader.now, high);
    for (int i = 0; i < 50; ++i) {
        leader.hear(peer, self, leader.term(), 1);
        leader.wait(10ms);
        leader.answer(peer);
    }
    ASSERT_TRUE(leader.membership.leads());
    EXPECT_EQ(leader.change.view().members.size(), 2U);
    EXPECT_FALSE(leader.logs.at(peer).is_frozen());
}

// P2: a member had missed it, and held less of its log than the leader, which heard it still: what
// lay between was delivered to nobody (simulator, seed 9736261).
TEST(ViewChange, WhomTheLeaderHearsIsNotTakenOverAtAMembersWord) {
    Leader leader;
    leader.begin();
    const LogId newcomer = test::log_of("newcomer");
    const election::Term former = leader.term();
    for (int i = 0; i < 60 && !leader.change.contains(newcomer); ++i) {
        leader.hear(peer, self, leader.term(), 1);
        leader.hear(high, peer, former, 1);  // follows another one, and answers nothing
        leader.hear(newcomer, self, leader.term(), 1);
        leader.wait(10ms);
        leader.answer(newcomer);
        leader.answer(peer, {.holds = {{high, 5}}, .addresses = {{high, test::address(3)}}});
    }
    ASSERT_TRUE(leader.change.contains(newcomer));
    ASSERT_FALSE(leader.change.contains(high));
    ASSERT_TRUE(leader.membership.is_alive(high));
    const auto& installed = leader.installed;
    ASSERT_TRUE(installed);
    EXPECT_TRUE(installed->ends.empty());
    EXPECT_TRUE(installed->assignments.empty());
    EXPECT_FALSE(leader.logs.at(high).is_frozen());
}

// P2: they dropped what it said then, and the only one that took it fell silent (simulator, faults
// `relapse`, seed 9941534).
TEST(ViewChange, AProposalWithAMemberThawsWhatAnEarlierOneFroze) {
    Leader member;
    member.begin();
    member.hear(high, high, member.term() + 1, 9);
    member.membership.on_left_out(member.now, peer);
    member.wait(60ms);
    View view{.number = {member.term(), high.broker, 1}, .members = {self, high}};
    std::ranges::sort(view.members);
    member.change.on_proposal(member.now, {.view = view, .removed = {peer}}, member.around(),
                              member.out);
    ASSERT_TRUE(member.logs.at(peer).is_frozen());
    member.hear(high, high, member.term(), 9);
    member.hear(peer, high, member.term(), 1);
    ++view.number.count;
    view.members.push_back(peer);
    std::ranges::sort(view.members);
    member.change.on_proposal(member.now, {.view = view, .removed = {}}, member.around(),
                              member.out);
    EXPECT_FALSE(member.logs.at(peer).is_frozen());
}

// P2: its sessions would have no heir. The leader may hear the new life long before we do.
TEST(ViewChange, AProposalWithALaterLifeOfABrokerEndsTheFormerOne) {
    Leader leader;
    leader.begin();
    leader.hear(high, high, leader.term() + 1, 9);
    leader.wait(10ms);
    ASSERT_FALSE(leader.membership.leads());
    ASSERT_TRUE(leader.membership.is_alive(peer));
    View view{.number = {leader.term(), high.broker, 1}, .members = {self, high}};
    view.members.push_back({peer.broker, peer.incarnation + 1});
    std::ranges::sort(view.members);
    leader.change.on_proposal(leader.now, {.view = view, .removed = {}}, leader.around(),
                              leader.out);
    EXPECT_TRUE(leader.logs.at(peer).is_frozen());
}

// P3: it had been replaced, and held more than those agreed on who went on; later it was the only
// one left who had been there (simulator, faults `relapse`, seed 9851395).
TEST(ViewChange, AnEndThatWasAgreedOnStays) {
    Leader member;
    member.begin();
    PeerLog& log = member.logs.at(peer);
    log.offer(1, {test::published(peer, 1), test::published(peer, 2), test::published(peer, 3)});
    while (log.has_next()) log.apply();
    member.hear(high, high, member.term() + 1, 9);
    member.membership.on_left_out(member.now, peer);
    member.wait(10ms);
    View view{.number = {member.term(), high.broker, 1}, .members = {self, high}};
    std::ranges::sort(view.members);
    member.change.on_announcement(member.now, {.view = view, .ends = {{peer, 2}}}, member.around());
    ASSERT_TRUE(log.is_frozen());
    ++view.number.count;
    member.out.clear();
    member.change.on_proposal(member.now, {.view = view, .removed = {peer}}, member.around(),
                              member.out);
    ASSERT_EQ(member.out.size(), 1U);
    EXPECT_EQ(std::get<ViewHoldings>(member.out[0].message).holds,
              (std::vector<LogPosition>{{peer, 2}}));
}

// P3: a newcomer stood still while it waited for the answers to its first proposal, took the others
// for unwilling, and went on alone from what it had read before (simulator, faults `relapse`, seed
// 9972482).
TEST(ViewChange, WhoStoodStillAsksAnew) {
    Leader leader;
    leader.begin();
    leader.hear(high, peer, leader.term(), 1);
    leader.wait(10ms);
    leader.out.clear();
    leader.now += 1s;
    leader.change.on_standstill();
    leader.hear(peer, self, leader.term(), 1);
    leader.hear(high, peer, leader.term(), 1);
    leader.wait(10ms);
    leader.answer(peer);
    EXPECT_FALSE(std::ranges::count(leader.change.view().members, high)) << "it has not answered";
    leader.answer(high);
    EXPECT_TRUE(leader.change.contains(high));
}

// They may come back together to those who lived on and have not met them yet (seed 1522201).
TEST(ViewChange, NewcomersListenForThoseWhoMayBeThere) {
    Leader leader;
    leader.lead();
    const Instant since = leader.now;
    while (leader.out.empty() && leader.now < since + 1s) {
        leader.hear(peer, self, leader.term(), 1);
        leader.wait(10ms);
    }
    EXPECT_FALSE(leader.out.empty());
    EXPECT_GT(leader.now, since + 100ms);
}

// P2, P3: two had been replaced, and the third, which had all sessions, stood still for a second or
// two. They went on without it, and it began anew: nobody had the sessions any more.
TEST(ViewChange, NewcomersWaitForOneThatHasTheSessionsAndIsSilent) {
    for (const bool has_ended : {false, true}) {
        Leader leader;
        const View without_us{.number = {1, high.broker, 1}, .members = {high}};
        leader.hear(high, high, 1, 1, without_us);
        if (has_ended) {
            leader.membership.on_beacon(leader.now,
                                        {.log = high, .tick = ++leader.ticks, .leaving = true});
        }
        const Instant since = leader.now;
        while (leader.out.empty() && leader.now < since + 5s) {
            leader.hear(peer, self, leader.term(), 1);
            leader.wait(10ms);
        }
        EXPECT_EQ(leader.now > since + 2500ms, !has_ended);
    }
}

TEST(ViewChange, ANewcomerJoinsThoseWhoLivedOnAtOnce) {
    Leader leader;
    leader.lead();
    leader.hear(peer, self, leader.term(), 1, {.number = {1, peer.broker, 1}, .members = {peer}});
    leader.wait(20ms);
    EXPECT_FALSE(leader.out.empty());
}

/// In a view with the peer, when a newcomer comes.
struct Host : Leader {
    void hear_both(bool peer_hears_it, bool it_hears_peer) {
        std::vector<BrokerId> heard{self.broker};
        if (peer_hears_it) heard.push_back(high.broker);
        hear(peer, self, term(), 1, change.view(), heard);
        heard = {self.broker};
        if (it_hears_peer) heard.push_back(peer.broker);
        hear(high, self, term(), 1, {}, heard);
        wait(10ms);
    }
    bool asks_it_in() {
        return std::ranges::any_of(out, [](const Outgoing& outgoing) {
            const auto* proposal = std::get_if<ViewProposal>(&outgoing.message);
            return proposal != nullptr && proposal->view.contains(high);
        });
    }
};

// A member that the newcomer did not hear had no lease until it did: clients waited (loops on
// radio, 5 brokers: 118 ms of silence filled all queues of the cell, and a pole fell).
TEST(ViewChange, ANewcomerJoinsWhenItAndEachMemberHaveFoundEachOther) {
    Host leader;
    leader.begin();
    leader.out.clear();
    for (int i = 0; i < 10; ++i) leader.hear_both(false, false);
    for (int i = 0; i < 10; ++i) leader.hear_both(true, false);
    for (int i = 0; i < 10; ++i) leader.hear_both(false, true);
    EXPECT_FALSE(leader.asks_it_in());
    leader.hear_both(true, true);
    EXPECT_TRUE(leader.asks_it_in());
}

TEST(ViewChange, ANewcomerThatAMemberNeverHearsIsNotWaitedForWithoutEnd) {
    Host leader;
    leader.begin();
    leader.out.clear();
    const Instant since = leader.now;
    const Duration most = leader.membership.times().unmet_peer_waited_for();
    while (!leader.asks_it_in() && leader.now < since + 2 * most) leader.hear_both(true, false);
    EXPECT_TRUE(leader.asks_it_in());
    EXPECT_GE(leader.now, since + most);
}

struct DoubtfulLeader : Leader {
    void hear_both() {
        for (const LogId& other : {peer, high}) {
            hear(other, self, term(), 1);
            lease.on_heard(now, other, ticks);
        }
    }
    /// In a view with both, and then it hears neither.
    void lose_both() {
        begin();
        for (int i = 0; i < 20 && !change.contains(high); ++i) {
            hear_both();
            wait(10ms);
            answer(peer);
            answer(high);
        }
        ASSERT_EQ(change.view().members.size(), 3U);
        installed.reset();
        out.clear();
        while (membership.is_alive(peer)) wait(10ms);
        ASSERT_FALSE(membership.is_alive(high));
    }
};

// I2: others have promised the same, and one of them may have entered it.
TEST(ViewChange, WhatAPromiseFroseStaysSoUntilAHigherOneHasItsWriterInIt) {
    DoubtfulLeader leader;
    leader.begin();
    for (int i = 0; i < 20 && !leader.change.contains(high); ++i) {
        leader.hear_both();
        leader.wait(10ms);
        leader.answer(peer);
        leader.answer(high);
    }
    leader.wait(30ms);
    leader.hear(high, self, leader.term(), 1);
    while (leader.membership.is_alive(peer)) leader.wait(10ms);
    ASSERT_TRUE(leader.logs.at(peer).is_frozen());
    while (leader.membership.is_alive(high)) leader.wait(10ms);
    EXPECT_TRUE(leader.logs.at(peer).is_frozen())
        << "the proposal is called off, the promise stays";
    leader.hear_both();
    leader.wait(10ms);
    EXPECT_FALSE(leader.logs.at(peer).is_frozen());
}

// I1: the others may still hold their leases.
TEST(ViewChange, WhoKeepsLessThanHalfTakesNobodysPlaceForThreeTerms) {
    DoubtfulLeader leader;
    leader.lose_both();
    leader.wait(150ms);
    EXPECT_FALSE(leader.proposes());
    EXPECT_FALSE(leader.logs.at(high).is_frozen());
    leader.hear_both();
    leader.wait(20ms);
    EXPECT_FALSE(leader.proposes());
    EXPECT_EQ(leader.change.view().members.size(), 3U);
    EXPECT_FALSE(leader.installed);
}

TEST(ViewChange, WhoHearsNobodyForThreeDetectionTimesGoesOnAlone) {
    DoubtfulLeader leader;
    leader.lose_both();
    leader.wait(220ms);
    EXPECT_EQ(leader.change.view().members, std::vector{self});
    EXPECT_TRUE(leader.logs.at(high).is_frozen());
}

// Its last beacons may have told of our former life.
TEST(ViewChange, ANewcomerOpensNoViewWithoutAPeerThatItHearsStill) {
    Leader leader;
    leader.wait(100ms);
    leader.hear(peer, self, leader.term(), 1);
    leader.wait(20ms);
    ASSERT_TRUE(leader.membership.leads());
    for (int i = 0; i < 20; ++i) {
        leader.hear_of_no_us(peer);
        leader.wait(10ms);
    }
    ASSERT_FALSE(leader.membership.is_alive(peer));
    EXPECT_FALSE(leader.change.has_view());
}

TEST(ViewChange, AProposalOutnumbersTheViewsOfAllWhomItAsks) {
    Leader leader;
    leader.begin();
    // The peer was in a view of its own for a moment, and follows us again.
    Beacon beacon{.log = peer, .tick = ++leader.ticks, .hears = {self.broker}};
    beacon.view = {.number = {leader.term() + 1, BrokerId{~0ULL}, 1}, .members = {peer}};
    beacon.promised = beacon.view.number;
    beacon.claim = {.rank = {.capability = 1, .id = node_of(peer.broker)},
                    .term = leader.term(),
                    .leader = node_of(self.broker)};
    leader.membership.on_beacon(leader.now, beacon);
    leader.out.clear();
    for (int i = 0; i < 30; ++i) {
        beacon.tick = ++leader.ticks;
        leader.membership.on_beacon(leader.now, beacon);
        leader.wait(10ms);
    }
    ASSERT_FALSE(leader.out.empty());
    const auto& proposal = std::get<ViewProposal>(leader.out.back().message);
    EXPECT_GT(proposal.view.number, beacon.view.number);
}

// Nobody has a lease before a newcomer is in the view, and an announcement may be late or lost.
TEST(ViewChange, AnAnnouncementIsSaidAgainToWhoHasNotInstalledIt) {
    DoubtfulLeader leader;
    leader.begin();
    const View before = leader.change.view();
    for (int i = 0; i < 20 && !leader.change.contains(high); ++i) {
        leader.hear_both();
        leader.wait(10ms);
        leader.answer(peer);
        leader.answer(high);
    }
    leader.out.clear();
    for (int i = 0; i < 4; ++i) {
        leader.hear(peer, self, leader.term(), 1);
        leader.hear(high, self, leader.term(), 1, before);
        leader.wait(10ms);
    }
    EXPECT_EQ(leader.said_to<ViewAnnouncement>(peer), 0U);
    EXPECT_GE(leader.said_to<ViewAnnouncement>(high), 1U);
    EXPECT_FALSE(leader.proposes());
}

// I4: or else a member whose leader went away before it announced would wait for ever.
TEST(ViewChange, ALeaderGoesBeyondWhatAMemberPromised) {
    Leader leader;
    leader.begin();
    Beacon beacon{.log = peer, .tick = ++leader.ticks, .hears = {self.broker}};
    beacon.view = leader.change.view();
    beacon.promised = {leader.term(), BrokerId{~0ULL}, 1};
    beacon.claim = {.rank = {.capability = 1, .id = node_of(peer.broker)},
                    .term = leader.term(),
                    .leader = node_of(self.broker)};
    leader.membership.on_beacon(leader.now, beacon);
    leader.out.clear();
    leader.wait(10ms);
    ASSERT_FALSE(leader.out.empty());
    EXPECT_GT(std::get<ViewProposal>(leader.out.back().message).view.number, beacon.promised);
    leader.answer(peer);
    EXPECT_GT(leader.change.view().number, beacon.promised);
}

// I4: its answers were on their way yet, and with them it entered a view below its promise.
TEST(ViewChange, WhoPromisesAHigherViewAnnouncesItsOwnNoMore) {
    Leader leader;
    leader.begin();
    leader.hear(high, self, leader.term(), 9);  // a newcomer, who is asked
    leader.wait(10ms);
    const ViewNumber own = leader.change.promised();
    ASSERT_GT(own, leader.change.view().number);
    View higher{{leader.term() + 1, high.broker, 1}, {high, self}};
    std::ranges::sort(higher.members);
    leader.hear(high, high, leader.term() + 1, 9);
    leader.change.on_proposal(leader.now, {.view = higher, .removed = {}}, leader.around(),
                              leader.out);
    ASSERT_EQ(leader.change.promised(), higher.number);
    for (const LogId& member : {peer, high}) {
        leader.change.on_holdings(leader.now, member, {.number = own}, leader.around(), leader.out);
    }
    EXPECT_LT(leader.change.view().number, own);
}

TEST(ViewChange, AProposalGoesWithItsLeadersTerm) {
    Leader leader;
    leader.begin();
    leader.hear(high, self, leader.term(), 1);  // a newcomer, who does not answer yet
    leader.wait(20ms);
    const election::Term before = leader.term();
    leader.hear(high, high, before + 1, 1);  // it led, out of our sight: our term grows
    leader.hear(high, self, before + 1, 1);
    leader.wait(20ms);
    ASSERT_GT(leader.term(), before);
    const auto& proposal = std::get<ViewProposal>(leader.out.back().message);
    EXPECT_EQ(proposal.view.number.term, leader.term());
}

TEST(ViewChange, SomebodyGoesOnForABrokerThatDiedOutsideOfTheView) {
    Leader leader;
    leader.begin();
    leader.logs.try_emplace(high, high, 1'000);  // it followed somebody else, and is gone
    leader.wait(10ms);
    leader.answer(peer);
    const auto& installed = leader.installed;
    ASSERT_TRUE(installed);
    EXPECT_TRUE(leader.logs.at(high).is_frozen());
    EXPECT_THAT(installed->ends, testing::ElementsAre(LogPosition{high, 0}));
}

}  // namespace
}  // namespace romano::cluster::view_change_test
