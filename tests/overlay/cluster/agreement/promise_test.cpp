// What a member promises, to whom, and when.
#include "tests/overlay/cluster/agreement/leader_and_peers.h"

namespace romano::cluster::view_change_test {
namespace {

/// Has promised a view to "high", which it follows.
struct Promised : Leader {
    View view;

    Promised() {
        begin();
        view = {{term() + 1, high.broker, 1}, {high, self}};
        std::ranges::sort(view.members);
        hear(high, high, view.number.term, 9);
        be_asked(view);
        EXPECT_EQ(change.promised(), view.number);
    }
    void be_asked(const View& proposed) {
        change.on_proposal(now, {.view = proposed, .removed = {}}, around(), out);
    }
};

// I4: it was taken back after four detection times, and a view below it entered.
TEST(ViewChange, NoClockTakesAPromiseBack) {
    Promised member;
    const ViewNumber promised = member.view.number;
    for (int i = 0; i < 100; ++i) {
        member.hear(high, high, promised.term, 9);
        member.wait(10ms);
    }
    EXPECT_EQ(member.change.promised(), promised);
    View older = member.view;
    older.number.count = 0;
    member.change.on_announcement(member.now, {.view = older}, member.around());
    EXPECT_LT(member.change.view().number, older.number);
}

// I1: two proposals of one leader came in another order than they left.
TEST(ViewChange, AProposalOlderThanThePromiseIsNotAnswered) {
    Promised member;
    const ViewNumber promised = member.view.number;
    member.out.clear();
    View older = member.view;
    older.number.count = 0;
    ASSERT_GT(older.number, member.change.view().number);
    member.be_asked(older);
    EXPECT_EQ(member.change.promised(), promised);
    EXPECT_TRUE(member.out.empty());
}

// It may have got the promise of each member but this one, and so may the leader.
TEST(ViewChange, AMemberAnswersWhomItFollows) {
    Leader member;
    member.begin();
    const ViewNumber before = member.change.promised();
    View view{{member.term(), high.broker, 1}, {high, self}};
    std::ranges::sort(view.members);
    ASSERT_GT(view.number, before);
    member.out.clear();
    member.change.on_proposal(member.now, {.view = view, .removed = {}}, member.around(),
                              member.out);
    EXPECT_EQ(member.change.promised(), before);
    EXPECT_TRUE(member.out.empty());
    member.hear(high, high, member.term() + 1, 9);
    member.change.on_proposal(member.now, {.view = view, .removed = {}}, member.around(),
                              member.out);
    EXPECT_EQ(member.change.promised(), view.number);
}

/// Follows "high", which leaves out "peer", a member of the view that is well to be heard.
struct DoubtfulMember : Leader {
    DoubtfulMember() {
        begin();
        hear(high, high, term() + 1, 9);
        ask(high, 1, {peer});
    }
    void ask(const LogId& leader, std::uint64_t count, std::vector<LogId> removed) {
        now += 10ms;
        hear(peer, high, term(), 1);
        hear(high, high, term(), 9);
        View view{{term(), leader.broker, count}, {leader, self}};
        std::ranges::sort(view.members);
        out.clear();
        change.on_proposal(now, {.view = view, .removed = std::move(removed)}, around(), out);
        change.on_tick(now, around(), out);
    }
    [[nodiscard]] bool has_answered() const { return said_to<ViewHoldings>(high) > 0; }
};

// Or everybody would be without a lease for as long as its number grows.
TEST(ViewChange, WhoIsHeardIsWaitedForOnceThoughTheProposalsNumberGrows) {
    DoubtfulMember member;
    const Instant since = member.now;
    std::uint64_t count = 1;
    while (!member.has_answered() && member.now < since + 1s) member.ask(high, ++count, {peer});
    EXPECT_GE(member.now, since + member.membership.times().disagreement_lasts());
    EXPECT_LE(member.now, since + member.membership.times().disagreement_lasts() + 20ms);
}

TEST(ViewChange, WhomTheMemberDoesNotFollowDoesNotDelayItsAnswer) {
    DoubtfulMember member;
    const Instant since = member.now;
    const LogId stranger = test::log_of("stranger");
    while (!member.has_answered() && member.now < since + 1s) {
        member.ask(stranger, 1, {});
        if (!member.has_answered()) member.ask(high, 1, {peer});
    }
    EXPECT_LE(member.now, since + member.membership.times().disagreement_lasts() + 30ms);
}

TEST(ViewChange, WhoIsNoMemberAnyMoreIsNotWaitedFor) {
    DoubtfulMember member;
    const LogId former = test::log_of("former");
    ASSERT_FALSE(member.has_answered());
    member.hear(former, former, 1, 1);
    member.ask(high, 2, {former});
    EXPECT_TRUE(member.has_answered());
}

TEST(ViewChange, AMemberInstallsWhatItPromisedOrHasFromItsLeader) {
    Leader member;
    member.begin();
    const ViewNumber before = member.change.view().number;
    View view{{member.term(), high.broker, 1}, {high, self}};
    std::ranges::sort(view.members);
    ASSERT_GT(view.number, member.change.promised());
    member.change.on_announcement(member.now, {.view = view}, member.around());
    EXPECT_EQ(member.change.view().number, before);
}

// Meanwhile the others may have gone on without it (simulator, faults `relapse`).
TEST(ViewChange, WhatWasPromisedBeforeAStandstillIsNotPromisedAnew) {
    Promised member;
    EXPECT_TRUE(member.change.is_promised_anew(member.view));
    member.change.on_standstill();
    EXPECT_FALSE(member.change.is_promised_anew(member.view));
}

}  // namespace
}  // namespace romano::cluster::view_change_test
