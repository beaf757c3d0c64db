#include "overlay/sim/invariants.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "tests/overlay/sim/cluster_scenario.h"

namespace romano::sim::invariants_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

// A judge that never finds anything is worth nothing: each invariant is broken once by hand.
class InvariantsTest : public testing::Test {
protected:
    InvariantsTest() {
        for (Sight& broker : brokers) {
            broker.is_speaking = true;
            broker.view = view(1, {0, 1, 2});
            broker.promised = broker.view.number;
        }
        for (std::size_t i = 0; i < brokers.size(); ++i) {
            brokers[i].name = "b" + std::to_string(i);
            brokers[i].log = log(i);
            brokers[i].times = {.beacon_every = beacon, .detection = detection};
            for (const std::size_t other : {0U, 1U, 2U}) {
                if (other != i) brokers[i].hears.push_back(log(other));
            }
        }
    }

    static broker::LogId log(std::size_t broker) { return {broker::BrokerId{broker + 1}, 1}; }
    static cluster::View view(std::uint64_t count, const std::vector<std::size_t>& members) {
        cluster::View made;
        made.number.count = count;
        for (const std::size_t member : members) made.members.push_back(log(member));
        return made;
    }
    std::vector<Invariant> after_step_of(std::size_t broker) {
        return invariants.judge(now, brokers, broker);
    }
    /// b2 is dead, and the view of the others says that its log ended there.
    void end_log_of_b2(broker::Seq end) {
        for (const std::size_t i : {0U, 1U}) {
            brokers[i].view = view(2, {0, 1});
            brokers[i].copies = {{log(2), end, end, LogCopy::End{end, brokers[i].view.number}}};
        }
        brokers[2].is_speaking = false;
    }

    static constexpr Duration beacon = 10ms;
    static constexpr Duration detection = 50ms;

    Instant now{1s};
    const Endpoint address = World::service_address(0);
    std::vector<Sight> brokers{3};
    Invariants invariants{100};
};

TEST_F(InvariantsTest, HoldWhereNothingHappens) {
    brokers[0].speaks_from = {address};
    brokers[0].speaks_to = {"robot"};
    for (const std::size_t i : {0U, 1U, 2U}) EXPECT_THAT(after_step_of(i), IsEmpty());
    EXPECT_THAT(invariants.breaches(), testing::Each(IsEmpty()));
}

TEST_F(InvariantsTest, OneSpeakerBreaksWhenTwoOfOneViewSpeakFromOneAddress) {
    brokers[0].speaks_from = {address};
    brokers[1].speaks_from = {address};
    brokers[1].is_speaking = false;
    EXPECT_THAT(after_step_of(0), IsEmpty());
    brokers[1].is_speaking = true;
    EXPECT_THAT(after_step_of(0), ElementsAre(Invariant::one_speaker));
    EXPECT_THAT(after_step_of(0), IsEmpty()) << "told once";
}

TEST_F(InvariantsTest, OneSpeakerBreaksAcrossViewsWithACommonMember) {
    brokers[0].speaks_from = {address};
    brokers[2].speaks_from = {address};
    brokers[0].view = view(3, {0});
    brokers[2].view = view(2, {1, 2});
    EXPECT_THAT(after_step_of(0), IsEmpty()) << "two sides of a cut";
    brokers[0].view = view(3, {0, 1});
    EXPECT_THAT(after_step_of(0), ElementsAre(Invariant::one_speaker));
}

TEST_F(InvariantsTest, OneSpeakerBreaksWhenOneSaysSomethingWhereAnotherMaySpeak) {
    brokers[0].is_speaking = false;
    brokers[0].speaks_from = {address};
    brokers[1].speaks_from = {address};
    EXPECT_THAT(after_step_of(0), IsEmpty()) << "it knows that it may not";
    brokers[0].said_from = {address};
    EXPECT_THAT(after_step_of(0), ElementsAre(Invariant::one_speaker)) << "and does";
}

TEST_F(InvariantsTest, AgreedEndBreaksWhenMembersSayDifferentEnds) {
    end_log_of_b2(7);
    EXPECT_THAT(after_step_of(0), IsEmpty());
    EXPECT_THAT(after_step_of(1), IsEmpty());
    brokers[1].copies[0].end->seq = 8;
    EXPECT_THAT(after_step_of(1), ElementsAre(Invariant::agreed_end));
}

TEST_F(InvariantsTest, AgreedEndBreaksWhenMoreIsTakenOfAnEndedLog) {
    end_log_of_b2(7);
    EXPECT_THAT(after_step_of(0), IsEmpty());
    brokers[0].copies[0].applied = 8;
    EXPECT_THAT(after_step_of(0), ElementsAre(Invariant::agreed_end));
}

TEST_F(InvariantsTest, SafeIsSafeBreaksWhenALogEndsBeforeWhatAMemberHoldsAndAClientKnows) {
    brokers[2].shown = 9;
    EXPECT_THAT(after_step_of(2), IsEmpty());
    end_log_of_b2(7);
    brokers[1].copies[0].applied = 9;
    EXPECT_THAT(after_step_of(0), ElementsAre(Invariant::safe_is_safe));
}

TEST_F(InvariantsTest, SafeIsSafeHoldsWhenWhatIsBeyondTheEndWasShownToNobody) {
    brokers[2].shown = 7;
    EXPECT_THAT(after_step_of(2), IsEmpty());
    end_log_of_b2(7);
    brokers[1].copies[0].applied = 9;
    EXPECT_THAT(after_step_of(0), IsEmpty());
}

TEST_F(InvariantsTest, SafeIsSafeBreaksWhenSomethingIsShownThatTooFewPeersHold) {
    brokers[0].holders = 1;
    brokers[1].copies = {{log(0), 5, 5, {}}};
    EXPECT_THAT(after_step_of(1), IsEmpty());
    brokers[0].shown = 5;
    EXPECT_THAT(after_step_of(0), IsEmpty());
    brokers[1].copies[0].acknowledged = 4;
    EXPECT_THAT(after_step_of(1), IsEmpty()) << "it held it";
    brokers[0].shown = 6;
    EXPECT_THAT(after_step_of(0), ElementsAre(Invariant::safe_is_safe));
}

TEST_F(InvariantsTest, NeverBackBreaksWhenTheNumberOfAViewFalls) {
    EXPECT_THAT(after_step_of(0), IsEmpty());
    brokers[0].view.number.count = 0;
    EXPECT_THAT(after_step_of(0), ElementsAre(Invariant::never_back));
}

TEST_F(InvariantsTest, NeverBackBreaksWhenAPromiseIsTakenBack) {
    brokers[0].promised.count = 5;
    EXPECT_THAT(after_step_of(0), IsEmpty());
    brokers[0].promised.count = 4;
    EXPECT_THAT(after_step_of(0), ElementsAre(Invariant::never_back));
}

TEST_F(InvariantsTest, NeverBackHoldsWhenABrokerBeginsANewLife) {
    brokers[0].promised.count = 5;
    EXPECT_THAT(after_step_of(0), IsEmpty());
    brokers[0].promised.count = 0;
    ++brokers[0].log.incarnation;
    EXPECT_THAT(after_step_of(0), IsEmpty());
}

TEST_F(InvariantsTest, OneOwnerBreaksWhenAnAddressChangesHandsWithoutAView) {
    brokers[1].speaks_from = {address};
    EXPECT_THAT(after_step_of(1), IsEmpty());
    brokers[1].speaks_from.clear();
    EXPECT_THAT(after_step_of(1), IsEmpty());
    brokers[0].speaks_from = {address};
    EXPECT_THAT(after_step_of(0), ElementsAre(Invariant::one_owner));
}

TEST_F(InvariantsTest, StateAtTheSealBreaksWhenAMirrorHasAnotherOneThanItsHomeLeft) {
    SessionBetween session{.moved = {log(0), 7}};
    session.image.header.client_id = "robot";
    session.image.worked_through = {{log(0), 5}, {log(1), 3}};
    brokers[0].leaving = {session};
    session.image.worked_through = {{log(0), 6}, {log(1), 3}, {log(2), 9}};
    brokers[1].mirrored = {session};
    EXPECT_THAT(after_step_of(1), IsEmpty()) << "no publish is between these positions";
    session.image.unreleased = {mqttsn::MsgId{1}};
    brokers[1].mirrored = {{{log(0), 6}, session.image}};
    EXPECT_THAT(after_step_of(1), IsEmpty()) << "that was another move";
    brokers[1].mirrored = {session};
    EXPECT_THAT(after_step_of(1), ElementsAre(Invariant::as_at_the_seal));
}

TEST_F(InvariantsTest, StateAtTheSealBreaksWhenAMirrorWorkedThroughLess) {
    SessionBetween session{.moved = {log(0), 7}};
    session.image.worked_through = {{log(1), 3}};
    brokers[0].leaving = {session};
    session.image.worked_through = {{log(1), 2}};
    brokers[1].mirrored = {session};
    EXPECT_THAT(after_step_of(1), ElementsAre(Invariant::as_at_the_seal));
}

TEST_F(InvariantsTest, OneOwnerHoldsWhenTheFirstSealedTheAddressForTheOther) {
    brokers[1].speaks_from = {address};
    EXPECT_THAT(after_step_of(1), IsEmpty());
    brokers[1].speaks_from.clear();
    brokers[1].sealed = {{address, log(0)}};
    EXPECT_THAT(after_step_of(1), IsEmpty());
    brokers[0].speaks_from = {address};
    EXPECT_THAT(after_step_of(0), IsEmpty());
    brokers[0].speaks_from.clear();
    brokers[2].speaks_from = {address};
    EXPECT_THAT(after_step_of(2), ElementsAre(Invariant::one_owner)) << "sealed for another one";
}

TEST_F(InvariantsTest, OneOwnerHoldsWhenAnAddressChangesHandsByAView) {
    brokers[1].speaks_from = {address};
    EXPECT_THAT(after_step_of(1), IsEmpty());
    brokers[1].speaks_from.clear();
    brokers[0].speaks_from = {address};
    brokers[0].view.number.count = 2;
    EXPECT_THAT(after_step_of(0), IsEmpty());
}

TEST_F(InvariantsTest, WhatIsNamedComesFirstBreaksWhenAMessageIsMissingThatWasAcknowledged) {
    brokers[0].copies = {{log(1), 3, 3, {}}, {log(2), 5, 5, {}}};
    brokers[0].references = {{log(1), {log(2), 5}, true}};
    EXPECT_THAT(after_step_of(0), IsEmpty());
    brokers[0].references = {{log(1), {log(2), 6}, false}};
    EXPECT_THAT(after_step_of(0), ElementsAre(Invariant::named_first));
}

TEST_F(InvariantsTest, WhatIsNamedComesFirstIsForMembersAsNoOtherAcknowledgementCounts) {
    brokers[0].copies = {{log(1), 3, 3, {}}};
    brokers[0].references = {{log(1), {log(2), 6}, false}};
    std::erase(brokers[0].view.members, log(0));
    EXPECT_THAT(after_step_of(0), IsEmpty());
}

TEST_F(InvariantsTest, OneShardBreaksWhenTwoThatMetLongAgoSpeakToOneClient) {
    brokers[0].speaks_to = {"robot"};
    brokers[1].speaks_to = {"robot"};
    brokers[1].view = view(2, {1, 2});
    EXPECT_THAT(after_step_of(0), IsEmpty()) << "two views";
    brokers[1].view = brokers[0].view;
    EXPECT_THAT(after_step_of(0), IsEmpty()) << "two sides that have just met";
    now += detection - 1ms;
    EXPECT_THAT(after_step_of(0), IsEmpty());
    brokers[0].hears.clear();
    EXPECT_THAT(after_step_of(0), IsEmpty()) << "and part again";
    brokers[0].hears = {log(1)};
    EXPECT_THAT(after_step_of(0), IsEmpty());
    now += detection;
    EXPECT_THAT(after_step_of(0), ElementsAre(Invariant::one_shard));
}

TEST_F(InvariantsTest, OneShardBreaksWhenTwoThatMetLongAgoBeginToSpeakToOneClient) {
    EXPECT_THAT(after_step_of(0), IsEmpty());
    now += detection;
    brokers[0].speaks_to = {"robot"};
    EXPECT_THAT(after_step_of(0), IsEmpty());
    brokers[1].speaks_to = {"robot"};
    EXPECT_THAT(after_step_of(1), ElementsAre(Invariant::one_shard));
}

TEST_F(InvariantsTest, OneShardBreaksWhenAHomeThatIsNotHeardKnowsOfAHigherCopyAndStays) {
    brokers[0].speaks_to = {"robot"};
    brokers[1].speaks_to = {"robot"};
    brokers[1].hears.clear();
    now += 10 * detection;
    EXPECT_THAT(after_step_of(0), IsEmpty());
    now += 10 * detection;
    EXPECT_THAT(after_step_of(1), IsEmpty()) << "it hears nobody, and cannot know";
    brokers[0].higher = {{"robot", log(1)}};
    EXPECT_THAT(after_step_of(0), IsEmpty());
    now += beacon + 1ms;
    brokers[0].higher.clear();
    EXPECT_THAT(after_step_of(0), IsEmpty()) << "its client spoke to it";
    brokers[0].higher = {{"robot", log(1)}};
    EXPECT_THAT(after_step_of(0), IsEmpty());
    now += beacon + 1ms;
    EXPECT_THAT(after_step_of(1), ElementsAre(Invariant::one_shard));
}

TEST_F(InvariantsTest, OneCopyBreaksWhenASessionIsHereAndLeavesAsWell) {
    EXPECT_THAT(after_step_of(0), IsEmpty());
    brokers[0].twice = {"robot"};
    EXPECT_THAT(after_step_of(0), ElementsAre(Invariant::one_copy));
}

TEST_F(InvariantsTest, BoundedBreaksWhenLogsOfOldLivesPileUp) {
    for (std::uint64_t life = 1; life <= 48; ++life) {
        brokers[0].copies.push_back({{broker::BrokerId{1}, life}, 1, 1, {}});
    }
    EXPECT_THAT(after_step_of(0), IsEmpty());
    brokers[0].copies.push_back({{broker::BrokerId{1}, 49}, 1, 1, {}});
    EXPECT_THAT(after_step_of(0), ElementsAre(Invariant::bounded));
}

TEST_F(InvariantsTest, BoundedBreaksWhenTheOwnLogKeepsMoreThanItMay) {
    brokers[0].own_events = 101;
    EXPECT_THAT(after_step_of(0), ElementsAre(Invariant::bounded));
}

class SightTest : public ClusterScenario {};

TEST_F(SightTest, IsWhatBrokersAre) {
    add_one_each({mqttsn::Qos::at_least_once});
    begin();
    const Sight& first = world.sight(0);
    const Sight& second = world.sight(1);
    EXPECT_TRUE(first.is_speaking);
    EXPECT_EQ(first.view, second.view);
    EXPECT_EQ(first.view.members.size(), 3U);
    EXPECT_THAT(first.speaks_from, ElementsAre(World::service_address(0)));
    EXPECT_THAT(first.speaks_to, ElementsAre("robot0"));
    ASSERT_NE(second.copy_of(first.log), nullptr);
    EXPECT_GT(first.shown, 0U);
    EXPECT_GE(second.copy_of(first.log)->applied, first.shown);
    EXPECT_EQ(first.holders, 1U);

    world.broker(1).crash();
    world.run_for(2s);
    EXPECT_FALSE(world.sight(1).is_speaking);
    const LogCopy* copy = world.sight(0).copy_of(second.log);
    ASSERT_NE(copy, nullptr);
    ASSERT_TRUE(copy->end.has_value());
    EXPECT_EQ(copy->end->in, world.sight(0).view.number);
}

}  // namespace
}  // namespace romano::sim::invariants_test
