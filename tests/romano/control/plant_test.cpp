// A loop's life at the plant, rule by rule: romano/control/README.md.
#include "romano/control/plant.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "tests/romano/control/ends.h"

namespace romano::control::plant_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;
using Change = std::pair<State, Reason>;

struct PlantTest : testing::Test {
    template <typename M>
    void hears(const M& message) {
        plant.on_message(now, octets_of(message), end);
    }
    /// Calls it whenever it wants to be called.
    void run_for(Duration time) {
        const Instant until = now + time;
        while (plant.next_wakeup() <= until) {
            now = std::max(now, plant.next_wakeup());
            plant.on_tick(now, end);
        }
        now = until;
    }
    Session ticket(Channel channel = Channel{0}) {
        hears(Ask{channel, operator_id});
        const auto reports = all_of<Report>(end.said);
        return reports.empty() ? Session::none : reports.back().session;
    }
    /// Opened, and accepted by the controller.
    void open(Open with = open_with(Session::none)) {
        with.ticket = ticket();
        session = with.ticket;
        hears(with);
        hears(Answer{session, Reason::none});
    }
    [[nodiscard]] Report last_report() const { return all_of<Report>(end.said).back(); }
    [[nodiscard]] Sample last_sample() const { return all_of<Sample>(end.said).back(); }
    [[nodiscard]] const PlantLoop& loop() const { return plant.loops()[0]; }
    static Command answer_to(const Sample& sample) {
        return {sample.session, sample.sequence, sample.tick, sample.value};
    }

    PlantEnd end;
    Plant<2> plant{{.id = plant_id, .seed = 7}};
    Instant now{1h};
    Session session{};
};

TEST_F(PlantTest, IsFreeAndTellsTheTicketToWhoAsks) {
    hears(Ask{Channel{1}, operator_id});
    ASSERT_THAT(end.said, SizeIs(1));
    EXPECT_EQ(end.said[0].to, operator_id);
    EXPECT_EQ(end.said[0].qos, Qos::at_least_once);
    EXPECT_EQ(last_report().state, State::free);
    EXPECT_EQ(last_report().reason, Reason::none);
    EXPECT_EQ(last_report().channel, Channel{1});
    EXPECT_NE(last_report().session, Session::none);
    EXPECT_EQ(ticket(Channel{1}), last_report().session);
    EXPECT_EQ(plant.next_wakeup(), never);
}

TEST_F(PlantTest, HasNoOtherChannels) {
    hears(Ask{Channel{2}, operator_id});
    EXPECT_EQ(last_report().reason, Reason::no_such_channel);
    Open open = open_with(Session{1});
    open.channel = Channel{2};
    hears(open);
    EXPECT_EQ(last_report().reason, Reason::no_such_channel);
}

TEST_F(PlantTest, FallsBackAndInvitesTheControllerWhenALoopIsOpened) {
    hears(open_with(ticket()));
    EXPECT_THAT(end.falls, ElementsAre(Fallback::stop));
    EXPECT_EQ(loop().state(), State::inviting);
    EXPECT_EQ(end.said.back().to, controller_id);
    const auto invite = end.said.back().as<Invite>();
    ASSERT_TRUE(invite);
    EXPECT_EQ(invite->plant, plant_id);
    EXPECT_EQ(invite->session, ticket());
    EXPECT_EQ(invite->period_ms, 20);
    EXPECT_EQ(invite->deadline_ms, 100);
    EXPECT_THAT(all_of<Sample>(end.said), IsEmpty());
}

TEST_F(PlantTest, OpensWithItsTicketOnly) {
    hears(open_with(Session::none));
    EXPECT_EQ(last_report().reason, Reason::wrong_ticket);
    const Session right = ticket();
    hears(open_with(Session{static_cast<std::uint32_t>(right) + 1}));
    EXPECT_EQ(last_report().reason, Reason::wrong_ticket);
    EXPECT_EQ(loop().state(), State::free);
}

TEST_F(PlantTest, ATicketOpensOneLoop) {
    open();
    const Open used = open_with(session);
    hears(End{session, operator_id});
    ASSERT_EQ(loop().state(), State::free);
    hears(used);
    EXPECT_EQ(last_report().reason, Reason::wrong_ticket);
    EXPECT_EQ(loop().state(), State::free);
    EXPECT_NE(ticket(), session);
    hears(used);
    EXPECT_EQ(loop().state(), State::free);
}

TEST_F(PlantTest, ADoubledOpenIsAnsweredAndDoesNothing) {
    open();
    const std::size_t said = end.said.size();
    hears(open_with(session));
    EXPECT_EQ(last_report().reason, Reason::none);
    EXPECT_EQ(last_report().state, State::waiting);
    EXPECT_EQ(end.said.size(), said + 1);
    EXPECT_THAT(end.falls, SizeIs(1));
}

TEST_F(PlantTest, AChannelIsInOneLoop) {
    open();
    hears(open_with(Session{1}));
    EXPECT_EQ(last_report().reason, Reason::busy);
    EXPECT_EQ(last_report().session, session);
    Open second = open_with(ticket(Channel{1}));
    second.channel = Channel{1};
    hears(second);
    EXPECT_EQ(plant.loops()[1].state(), State::inviting);
    EXPECT_EQ(loop().state(), State::waiting);
}

TEST_F(PlantTest, RefusesImpossibleSettings) {
    const auto reason_for = [&](std::uint16_t period_ms, std::uint16_t deadline_ms) {
        Open open = open_with(ticket());
        open.period_ms = period_ms;
        open.deadline_ms = deadline_ms;
        hears(open);
        return last_report().reason;
    };
    EXPECT_EQ(reason_for(0, 100), Reason::impossible_settings);
    EXPECT_EQ(reason_for(20, 0), Reason::impossible_settings);
    EXPECT_EQ(reason_for(20, 20), Reason::impossible_settings);
    EXPECT_EQ(reason_for(20, 641), Reason::impossible_settings);
    EXPECT_EQ(loop().state(), State::free);
    EXPECT_EQ(reason_for(20, 640), Reason::none);
    EXPECT_EQ(loop().state(), State::inviting);
}

TEST_F(PlantTest, CanSayNo) {
    end.is_willing = false;
    hears(open_with(ticket()));
    EXPECT_EQ(last_report().reason, Reason::not_allowed);
    EXPECT_EQ(loop().state(), State::free);
}

TEST_F(PlantTest, InvitesFiveTimesASecondApart) {
    hears(open_with(ticket()));
    run_for(4999ms);
    EXPECT_THAT(all_of<Invite>(end.said), SizeIs(5));
    EXPECT_EQ(loop().state(), State::inviting);
    run_for(1ms);
    EXPECT_EQ(end.states.back(), Change(State::free, Reason::no_answer));
    EXPECT_EQ(last_report().reason, Reason::no_answer);
    EXPECT_THAT(end.falls, SizeIs(1));
    EXPECT_EQ(plant.next_wakeup(), never);
}

TEST_F(PlantTest, EndsWhenTheControllerRefuses) {
    hears(open_with(ticket()));
    hears(Answer{ticket(), Reason::no_such_law});
    EXPECT_EQ(loop().state(), State::free);
    EXPECT_EQ(last_report().reason, Reason::no_such_law);
}

TEST_F(PlantTest, SamplesEachPeriodWithSequenceAndTick) {
    open();
    run_for(40ms);
    const auto samples = all_of<Sample>(end.said);
    ASSERT_THAT(samples, SizeIs(3));
    for (std::uint32_t i = 0; i < 3; ++i) {
        EXPECT_EQ(samples[i].sequence, i);
        EXPECT_EQ(samples[i].tick, 3'600'000'000U + i * 20'000U);
        EXPECT_EQ(samples[i].age, Sample::no_age);
        EXPECT_THAT(samples[i].value, ElementsAre(i + 1));
    }
    EXPECT_EQ(end.said.back().to, controller_id);
    EXPECT_EQ(end.said.back().qos, Qos::at_most_once);
}

TEST_F(PlantTest, WhatAStallMissedIsNotSampledLater) {
    open();
    now += 95ms;
    plant.on_tick(now, end);
    EXPECT_THAT(all_of<Sample>(end.said), SizeIs(2));
    EXPECT_EQ(plant.next_wakeup(), now + 20ms);
}

TEST_F(PlantTest, CarriesACommandOutAndTellsItsAge) {
    open();
    run_for(7ms);
    hears(answer_to(last_sample()));
    EXPECT_THAT(end.did, ElementsAre(ElementsAre(1)));
    EXPECT_EQ(loop().state(), State::controlled);
    EXPECT_EQ(loop().ages().last, 7'000U);
    run_for(20ms);
    EXPECT_EQ(last_sample().age, 70);
}

TEST_F(PlantTest, CarriesNothingOutTwiceOrOutOfOrder) {
    open();
    const Command first = answer_to(last_sample());
    run_for(20ms);
    const Command second = answer_to(last_sample());
    hears(second);
    hears(second);
    hears(first);
    EXPECT_THAT(end.did, SizeIs(1));
    EXPECT_EQ(loop().counters().repeated, 2U);
}

TEST_F(PlantTest, CarriesNothingOutThatIsAsOldAsTheDeadline) {
    open();
    const Command first = answer_to(last_sample());
    run_for(20ms);
    const Command second = answer_to(last_sample());
    run_for(80ms);
    hears(first);
    EXPECT_THAT(end.did, IsEmpty());
    EXPECT_EQ(loop().counters().late, 1U);
    run_for(19ms);
    hears(second);
    EXPECT_THAT(end.did, SizeIs(1));
}

TEST_F(PlantTest, CarriesOutAnswersToItsOwnSamplesOnly) {
    open();
    const Command good = answer_to(last_sample());
    Command bad = good;
    ++bad.tick;
    hears(bad);
    bad = good;
    ++bad.sequence;  // not sent yet
    hears(bad);
    EXPECT_EQ(loop().counters().foreign, 2U);
    bad = good;
    bad.session = Session{static_cast<std::uint32_t>(good.session) + 1};
    hears(bad);
    EXPECT_EQ(plant.counters().foreign, 1U);
    EXPECT_THAT(end.did, IsEmpty());
    hears(good);
    EXPECT_THAT(end.did, SizeIs(1));
}

TEST_F(PlantTest, CommandsOfAnEarlierLoopAreForeign) {
    open();
    hears(answer_to(last_sample()));
    const Command old = answer_to(last_sample());
    hears(End{session, operator_id});
    open();
    hears(old);
    EXPECT_EQ(plant.counters().foreign, 1U);
    EXPECT_EQ(loop().state(), State::waiting);
}

TEST_F(PlantTest, FallsBackOnceWhenTheCommandInForceIsAsOldAsTheDeadline) {
    open();
    run_for(30ms);
    hears(answer_to(last_sample()));  // taken at 20 ms
    run_for(89ms);
    EXPECT_EQ(loop().state(), State::controlled);
    EXPECT_THAT(end.falls, SizeIs(1));
    run_for(1ms);
    EXPECT_EQ(loop().state(), State::waiting);
    EXPECT_THAT(end.falls, SizeIs(2));
    run_for(10s);
    EXPECT_THAT(end.falls, SizeIs(2));
    EXPECT_EQ(loop().counters().falls, 1U);
}

TEST_F(PlantTest, InvitesAgainWhileItWaitsAndIsControlledAgain) {
    open();
    hears(answer_to(last_sample()));
    end.said.clear();
    run_for(3s);
    EXPECT_THAT(all_of<Invite>(end.said), SizeIs(3));
    EXPECT_THAT(all_of<Sample>(end.said), SizeIs(150));
    hears(answer_to(last_sample()));
    EXPECT_EQ(loop().state(), State::controlled);
    run_for(100ms);
    EXPECT_THAT(end.falls, SizeIs(3));
}

TEST_F(PlantTest, EndsAsItFallsBackIfToldSo) {
    Open with = open_with(Session::none);
    with.ends_then = true;
    with.fallback = Fallback::own_law;
    open(with);
    hears(answer_to(last_sample()));
    run_for(100ms);
    EXPECT_EQ(end.states.back(), Change(State::free, Reason::fell_back));
    EXPECT_THAT(end.falls, ElementsAre(Fallback::own_law, Fallback::own_law));
}

TEST_F(PlantTest, HoldsWhileTheLoopLivesAndThenStops) {
    Open with = open_with(Session::none);
    with.fallback = Fallback::hold;
    open(with);
    hears(answer_to(last_sample()));
    run_for(1s);
    EXPECT_THAT(end.falls, ElementsAre(Fallback::hold, Fallback::hold));
    hears(answer_to(last_sample()));
    hears(End{session, operator_id});
    EXPECT_THAT(end.falls, ElementsAre(Fallback::hold, Fallback::hold, Fallback::stop));
}

TEST_F(PlantTest, ACallThatComesLateFallsBackBeforeItHeedsACommand) {
    open();
    hears(answer_to(last_sample()));
    run_for(80ms);
    const Command young = answer_to(last_sample());
    now += 50ms;
    hears(young);
    EXPECT_THAT(
        end.states,
        ElementsAre(Change(State::inviting, Reason::none), Change(State::waiting, Reason::none),
                    Change(State::controlled, Reason::none), Change(State::waiting, Reason::none),
                    Change(State::controlled, Reason::none)));
    EXPECT_THAT(end.falls, SizeIs(2));
    EXPECT_THAT(end.did, SizeIs(2));
}

TEST_F(PlantTest, FallsBackWhenTheLoopEnds) {
    open();
    hears(answer_to(last_sample()));
    hears(End{session, *RomanoId::parse("0000000f")});
    EXPECT_THAT(end.falls, SizeIs(2));
    EXPECT_EQ(end.said.back().to, *RomanoId::parse("0000000f"));
    EXPECT_EQ(last_report().reason, Reason::ended_by_a_node);
    EXPECT_EQ(last_report().counters.accepted, 1U);
    const auto bye = all_of<Bye>(end.said);
    ASSERT_THAT(bye, SizeIs(1));
    EXPECT_EQ(bye[0].session, session);
    hears(End{session, operator_id});
    EXPECT_EQ(last_report().reason, Reason::no_such_loop);
    EXPECT_THAT(end.falls, SizeIs(2));
}

TEST_F(PlantTest, EndsByItself) {
    open();
    hears(answer_to(last_sample()));
    plant.end(now, Channel{0}, end);
    plant.end(now, Channel{0}, end);
    plant.end(now, Channel{9}, end);
    EXPECT_THAT(end.falls, SizeIs(2));
    EXPECT_EQ(last_report().reason, Reason::not_allowed);
}

TEST_F(PlantTest, EndsWithItsLeaseUnlessThatIsRenewed) {
    Open with = open_with(Session::none);
    with.lease_s = 2;
    open(with);
    run_for(1900ms);
    hears(Renew{session, operator_id});
    run_for(1999ms);
    EXPECT_EQ(loop().state(), State::waiting);
    run_for(1ms);
    EXPECT_EQ(end.states.back(), Change(State::free, Reason::lease_over));
    hears(Renew{session, operator_id});
    EXPECT_EQ(last_report().reason, Reason::no_such_loop);
}

TEST_F(PlantTest, ReportsUnaskedOnceASecondHoweverOftenItFallsBack) {
    Open with = open_with(Session::none);
    with.deadline_ms = 21;
    open(with);
    end.said.clear();
    run_for(20ms);
    for (int i = 0; i < 200; ++i) {
        hears(answer_to(last_sample()));
        run_for(25ms);
    }
    EXPECT_GT(loop().counters().falls, 90U);
    EXPECT_THAT(all_of<Report>(end.said), SizeIs(testing::Le(6)));
}

TEST_F(PlantTest, TwoStartsWithOneSeedHaveOtherTickets) {
    const Session first = ticket();
    Plant<2> again{{.id = plant_id, .seed = 7}};
    again.on_message(now + 1ms, octets_of(Ask{Channel{0}, operator_id}), end);
    EXPECT_NE(last_report().session, first);
}

TEST_F(PlantTest, CountsWhatIsNoMessageAndPassesOverWhatIsForControllers) {
    plant.on_message(now, Octets{0xC0, 3, 99}, end);
    EXPECT_EQ(plant.counters().malformed, 1U);
    hears(Sample{Session{1}, 2, 3, 4, {}});
    hears(Bye{Session{1}, Reason::none});
    EXPECT_EQ(plant.counters().malformed, 1U);
    EXPECT_THAT(end.said, IsEmpty());
}

}  // namespace
}  // namespace romano::control::plant_test
