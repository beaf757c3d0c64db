// The controller, rule by rule: romano/control/README.md.
#include "romano/control/controller.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "tests/romano/control/ends.h"

namespace romano::control::controller_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

struct ControllerTest : testing::Test {
    template <typename M>
    void hears(const M& message) {
        controller.on_message(now, octets_of(message), end);
    }
    static Invite invite(std::uint32_t session, const RomanoId& plant = plant_id,
                         Channel channel = Channel{0}) {
        return {Session{session}, plant, channel, Law{1}, 20, 100, {}};
    }
    static Sample sample(std::uint32_t sequence, std::uint32_t tick = 0) {
        return {Session{1}, sequence, tick, Sample::no_age, value};
    }
    [[nodiscard]] Reason last_answer() const { return all_of<Answer>(end.said).back().reason; }

    static inline const Octets value = {42};
    ControllerEnd end;
    Controller<2> controller{controller_id};
    Instant now{1h};
};

TEST_F(ControllerTest, AcceptsAnInvitationAndAnswersEachSampleAtOnce) {
    hears(invite(1));
    EXPECT_EQ(end.said.back().to, plant_id);
    EXPECT_EQ(end.said.back().qos, Qos::at_least_once);
    EXPECT_EQ(last_answer(), Reason::none);
    hears(sample(5, 77));
    EXPECT_THAT(end.samples, ElementsAre(value));
    const auto command = end.said.back().as<Command>();
    ASSERT_TRUE(command);
    EXPECT_EQ(command->session, Session{1});
    EXPECT_EQ(command->sequence, 5U);
    EXPECT_EQ(command->tick, 77U);
    EXPECT_THAT(command->value, ElementsAre(42));
    EXPECT_EQ(end.said.back().qos, Qos::at_most_once);
}

TEST_F(ControllerTest, ItsLawNeedNotCommand) {
    hears(invite(1));
    end.is_mute = true;
    hears(sample(0));
    EXPECT_THAT(end.samples, SizeIs(1));
    EXPECT_THAT(all_of<Command>(end.said), IsEmpty());
}

TEST_F(ControllerTest, HandsOverNewerSamplesOnly) {
    hears(invite(1));
    for (const std::uint32_t sequence : {0xFFFF'FFFEU, 0xFFFF'FFFEU, 0xFFFF'FFFDU, 1U, 0U}) {
        hears(sample(sequence));
    }
    EXPECT_THAT(end.samples, SizeIs(2));
    EXPECT_EQ(controller.loops()[0].counters().repeated, 3U);
    EXPECT_EQ(controller.loops()[0].counters().missing, 2U);
}

TEST_F(ControllerTest, ASecondInvitationIsAnsweredAndBeginsTheOrderAnew) {
    hears(invite(1));
    hears(sample(1'000'000));  // garbled on its way
    hears(sample(3));
    EXPECT_THAT(end.samples, SizeIs(1));
    hears(invite(1));
    EXPECT_THAT(end.begun, SizeIs(1));
    EXPECT_THAT(all_of<Answer>(end.said), SizeIs(2));
    hears(sample(4));
    EXPECT_THAT(end.samples, SizeIs(2));
}

TEST_F(ControllerTest, RefusesALawThatItDoesNotHave) {
    Invite other = invite(1);
    other.law = Law{2};
    hears(other);
    EXPECT_EQ(last_answer(), Reason::no_such_law);
    hears(sample(0));
    EXPECT_EQ(controller.counters().foreign, 1U);
    EXPECT_EQ(controller.counters().refused, 1U);
}

TEST_F(ControllerTest, HasAFixedNumberOfPlaces) {
    hears(invite(1));
    hears(invite(2, plant_id, Channel{1}));
    hears(invite(3, plant_id, Channel{2}));
    EXPECT_EQ(last_answer(), Reason::controller_full);
    hears(Bye{Session{1}, Reason::ended_by_a_node});
    EXPECT_THAT(end.ended, ElementsAre(std::pair(Place{0}, Reason::ended_by_a_node)));
    hears(invite(3, plant_id, Channel{2}));
    EXPECT_EQ(last_answer(), Reason::none);
    EXPECT_THAT(end.begun, ElementsAre(Place{0}, Place{1}, Place{0}));
}

TEST_F(ControllerTest, ANewSessionOfAPlantsChannelTakesTheOldOnesPlace) {
    hears(invite(1));
    hears(invite(2));
    EXPECT_THAT(end.ended, SizeIs(1));
    hears(sample(0));
    EXPECT_EQ(controller.counters().foreign, 1U);
    EXPECT_TRUE(controller.loops()[1].is_free());
}

TEST_F(ControllerTest, TwoPlantsMayNotHaveOneSession) {
    hears(invite(1));
    hears(invite(1, operator_id));
    EXPECT_EQ(last_answer(), Reason::session_in_use);
    hears(invite(0, operator_id));
    EXPECT_EQ(last_answer(), Reason::no_such_loop);
    hears(sample(0));
    EXPECT_EQ(end.said.back().to, plant_id);
}

TEST_F(ControllerTest, GivesASilentPlantUpAfterTenSecondsAndThreePeriods) {
    hears(invite(1));
    now += 5s;
    hears(sample(0));
    now += 10'059ms;
    controller.on_tick(now, end);
    EXPECT_THAT(end.ended, IsEmpty());
    EXPECT_EQ(controller.next_wakeup(), now + 1ms);
    now += 1ms;
    controller.on_tick(now, end);
    EXPECT_THAT(end.ended, ElementsAre(std::pair(Place{0}, Reason::no_answer)));
    EXPECT_EQ(controller.next_wakeup(), never);
}

TEST_F(ControllerTest, CanLeaveALoop) {
    hears(invite(1));
    controller.end(Place{0}, end);
    controller.end(Place{0}, end);
    controller.end(Place{7}, end);
    const auto ends = all_of<End>(end.said);
    ASSERT_THAT(ends, SizeIs(1));
    EXPECT_EQ(ends[0].session, Session{1});
    EXPECT_EQ(ends[0].asker, controller_id);
    EXPECT_THAT(end.ended, SizeIs(1));
}

TEST_F(ControllerTest, KnowsTheJitterOfSamplesWithoutACommonClock) {
    hears(invite(1));
    for (std::uint32_t i = 0; i < 50; ++i) {
        now += i % 2 == 0 ? 18ms : 22ms;
        hears(sample(i, i * 20'000U + 4'000'000'000U));
    }
    EXPECT_NEAR(controller.loops()[0].counters().jitter, 1'950, 100);
}

TEST_F(ControllerTest, CountsWhatIsNoMessageAndPassesOverWhatIsForPlants) {
    controller.on_message(now, Octets{0xC0, 3, 99}, end);
    EXPECT_EQ(controller.counters().malformed, 1U);
    hears(Ask{Channel{0}, operator_id});
    hears(Command{Session{1}, 0, 0, value});
    EXPECT_THAT(end.said, IsEmpty());
}

}  // namespace
}  // namespace romano::control::controller_test
