#include "experiments/fleet/orders.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <stdexcept>
#include <variant>

#include "experiments/fleet/loop_stop.h"

namespace romano::experiments::orders_test {
namespace {

using namespace std::chrono_literals;
using control::Channel;
using control::Reason;
using control::Report;
using control::Session;
using control::State;
using message::RomanoId;
using ::testing::ElementsAre;

const RomanoId robot_1 = *RomanoId::parse("00000001");
const RomanoId robot_2 = *RomanoId::parse("00000002");

SeenRobot a_robot(const RomanoId& id, server::Form form) {
    SeenRobot robot;
    robot.entry.id = id;
    robot.entry.form = form;
    return robot;
}

TEST(Orders, AMoveIsInTheRobotsFormAndCarriedOutOnce) {
    const Orders move = move_orders(a_robot(robot_1, server::Form::binary), "front", "10cm");
    ASSERT_EQ(move.orders.size(), 1U);
    EXPECT_EQ(move.orders[0].topic, "00000001");
    EXPECT_EQ(move.orders[0].qos, mqttsn::Qos::exactly_once);
    EXPECT_THAT(move.orders[0].octets, ElementsAre(7, 8, 0, 0, 0, 0, 0, 100));
    EXPECT_EQ(move.words, "move front 10cm");
    EXPECT_THROW((void)move_orders(a_robot(robot_1, server::Form::legacy), "front", "10cm"),
                 std::invalid_argument);
}

TEST(Orders, StopIsAMovementOfNothing) {
    EXPECT_THAT(stop_orders(a_robot(robot_1, server::Form::binary)).orders[0].octets,
                ElementsAre(7, 8, 0, 0, 0, 0, 0, 0));
    const Octets legacy = stop_orders(a_robot(robot_1, server::Form::legacy)).orders[0].octets;
    EXPECT_EQ(as_text(legacy), "7040000000000");
}

TEST(Orders, StopAllIsSaidToAllAtOnceAndThenToEach) {
    FleetPicture picture{Duration{0}};
    for (const RomanoId& id : {robot_1, robot_2}) {
        server::NodeEntry entry;
        entry.id = id;
        picture.on_entry(Instant{1s}, entry);
    }
    const Orders all = stop_all_orders(picture);
    EXPECT_THAT(all.robots, ElementsAre(robot_1, robot_2));
    ASSERT_EQ(all.orders.size(), 3U);
    EXPECT_EQ(all.orders[0].topic, "common");
    EXPECT_EQ(all.orders[1].topic, "00000001");
    EXPECT_EQ(all.orders[2].topic, "00000002");
}

TEST(Orders, StopAllIsSaidToAllInTheFormOfTheAuthorsFirmwareWhereARobotHasIt) {
    FleetPicture picture{Duration{0}};
    for (const RomanoId& id : {robot_1, robot_2}) {
        server::NodeEntry entry;
        entry.id = id;
        entry.form = id == robot_2 ? server::Form::legacy : server::Form::binary;
        picture.on_entry(Instant{1s}, entry);
    }
    const Orders all = stop_all_orders(picture);
    ASSERT_EQ(all.orders.size(), 4U);
    EXPECT_EQ(all.orders[0].topic, "common");
    EXPECT_EQ(all.orders[1].topic, "common");
    EXPECT_EQ(as_text(all.orders[1].octets), "7040000000000");
    EXPECT_EQ(all.orders[2].topic, robot_1.text());
    EXPECT_EQ(all.orders[3].topic, robot_2.text());
}

/// What was said, decoded again.
template <typename Message>
Message said(const LoopStop::ToRobot& message) {
    return std::get<Message>(*control::decode(message.octets));
}

std::vector<LoopStop::ToRobot> answer(LoopStop& stop, Instant now, const Report& report) {
    std::array<std::uint8_t, control::largest_message> octets{};
    const std::size_t size = control::encode(report, octets);
    return stop.on_answer(now, Bytes{octets}.first(size));
}

Report report_of(unsigned channel, State state, Reason reason = Reason::none) {
    Report report{};
    report.channel = Channel{static_cast<std::uint8_t>(channel)};
    report.session = Session{77};
    report.plant = robot_1;
    report.state = state;
    report.reason = reason;
    return report;
}

TEST(LoopStop, EndsTheLoopsOfAllChannelsOneByOne) {
    LoopStop stop{robot_2};
    const Instant now{1s};
    const LoopStop::ToRobot first = stop.begin(now, robot_1);
    EXPECT_EQ(first.robot, robot_1);
    EXPECT_EQ(said<control::Ask>(first).asker, robot_2);
    auto next = answer(stop, now, report_of(0, State::controlled));
    ASSERT_EQ(next.size(), 1U);
    EXPECT_EQ(said<control::End>(next[0]).session, Session{77});
    next = answer(stop, now, report_of(0, State::free, Reason::ended_by_a_node));
    ASSERT_EQ(next.size(), 1U);
    EXPECT_EQ(said<control::Ask>(next[0]).channel, Channel{1});
    EXPECT_TRUE(answer(stop, now, report_of(1, State::free, Reason::no_such_channel)).empty());
}

TEST(LoopStop, ARobotThatIsBegunAgainHasItsTimeAnew) {
    LoopStop stop{robot_2};
    (void)stop.begin(Instant{1s}, robot_1);
    (void)stop.begin(Instant{9s}, robot_1);
    (void)stop.begin(Instant{12s}, robot_2);
    EXPECT_EQ(answer(stop, Instant{18s}, report_of(0, State::controlled)).size(), 1U);
    EXPECT_TRUE(answer(stop, Instant{20s}, report_of(0, State::controlled)).empty());
}

TEST(LoopStop, EndsNoLoopThatNobodyWantedEnded) {
    LoopStop stop{robot_2};
    EXPECT_TRUE(answer(stop, Instant{1s}, report_of(0, State::controlled)).empty());
    (void)stop.begin(Instant{1s}, robot_1);
    EXPECT_TRUE(answer(stop, Instant{30s}, report_of(0, State::controlled)).empty());
    EXPECT_TRUE(stop.on_answer(Instant{2s}, as_octets("no message of a loop")).empty());
}

}  // namespace
}  // namespace romano::experiments::orders_test
