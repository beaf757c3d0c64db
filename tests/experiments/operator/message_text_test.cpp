#include "experiments/operator/message_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>
#include <vector>

#include "experiments/operator/robot_message.h"
#include "romano/control/messages.h"

namespace romano::experiments::message_text_test {
namespace {

std::string line_of(const Octets& octets) {
    const auto message = romano_message("team/red", octets);
    return message ? to_line(*message) : "none";
}

TEST(MessageText, SaysMovementsAsTheOperatorDoes) {
    EXPECT_EQ(line_of(move_message(Form::binary, "front", "10cm", 0)),
              "movement-control movement=front mm=100");
    EXPECT_EQ(line_of(move_message(Form::binary, "rotate-left", "90deg", 0)),
              "movement-control movement=rotate-left mdeg=90000");
    EXPECT_EQ(line_of(move_message(Form::binary, "0x8001", "0a0b", 0)),
              "movement-control movement=0x8001 octets=0a0b");
}

TEST(MessageText, SaysWhatIsAskedOfARobot) {
    EXPECT_EQ(line_of(subscribe_message(Form::binary, "team/red")),
              "mqtt-subscribe topic=team/red");
    EXPECT_EQ(line_of(request_message(Form::binary, "telemetry", "two words")),
              "mqtt-publish-request topic=telemetry kind=\"two words\"");
}

TEST(MessageText, SaysWhatARobotTells) {
    EXPECT_EQ(line_of({0x06, 16, 0, 2, 0, 0, 0, 1, 0xFF, 0xFF, 0xFF, 0xFF, 0, 1, 0x5F, 0x90}),
              "sensor-data sensor=location x_mm=1 y_mm=-1 heading_mdeg=90000");
    EXPECT_EQ(line_of({0x0A, 10, 'a', 'b', 'c', 'd', '1', '2', '3', '4'}),
              "heartbeat sender=abcd1234");
    EXPECT_EQ(line_of({0x00, 2}), "normal-data text=\"\"");
    EXPECT_EQ(line_of({0x00, 3, 0x07}), "normal-data octets=07");
}

template <typename M>
std::string loop_line_of(const M& message) {
    Octets octets(control::largest_message);
    octets.resize(control::encode(message, octets));
    const auto romano = romano_message("00000002", octets);
    return romano ? to_line(*romano) : "none";
}

TEST(MessageText, SaysWhatPassesInAControlLoop) {
    const auto plant = *message::RomanoId::parse("00000002");
    const control::Session session{7};
    const Octets value = {0, 0, 0, 100};
    EXPECT_EQ(loop_line_of(control::Ask{control::Channel{1}, plant}),
              "loop-ask channel=1 asker=00000002");
    EXPECT_EQ(loop_line_of(control::Sample{session, 3, 60'000, 52, value}),
              "loop-sample session=7 sequence=3 tick_us=60000 last_age_ms=5.2 value=00000064");
    EXPECT_EQ(loop_line_of(control::Sample{session, 0, 0, control::Sample::no_age, {}}),
              "loop-sample session=7 sequence=0 tick_us=0 value=\"\"");
    EXPECT_EQ(loop_line_of(control::Command{session, 3, 60'000, value}),
              "loop-command session=7 sequence=3 tick_us=60000 value=00000064");
    EXPECT_EQ(loop_line_of(control::Answer{session, control::Reason::no_such_law}),
              "loop-answer session=7 reason=\"the controller has no such law, or cannot "
              "use these parameters\"");
    EXPECT_EQ(loop_line_of(control::Invite{session, plant, {}, control::Law{2}, 20, 95, value}),
              "loop-invite session=7 plant=00000002 channel=0 law=2 period_ms=20 deadline_ms=95 "
              "parameters=00000064");
    control::Report report{};
    report.state = control::State::controlled;
    report.counters.samples = 12;
    EXPECT_THAT(loop_line_of(report), testing::HasSubstr("state=controlled"));
    EXPECT_THAT(loop_line_of(report), testing::HasSubstr("samples=12"));
}

TEST(MessageText, OfALoopThatIsMalformedSaysItsOctets) {
    const Octets octets = {0xC0, 4, 9, 1};
    EXPECT_EQ(to_line(*romano_message("00000002", octets)), "0x00c0 octets=0901");
}

TEST(MessageText, IsAnObjectForPrograms) {
    const auto octets = move_message(Form::binary, "back", "1m", 0);
    EXPECT_EQ(to_json(*romano_message("abcd1234", octets)).dump(),
              R"({"type":"movement-control","movement":"back","mm":1000})");
}

TEST(MessageText, ATextIsNoMessageOfAnApplicationButOnATopicOfRomano) {
    const std::vector<std::uint8_t> octets = {'x', 3, '='};
    EXPECT_FALSE(romano_message("robots/7/pose", octets));
    EXPECT_TRUE(romano_message("common", octets));
    EXPECT_FALSE(romano_message("common", as_octets("x=1 y=2")));
}

TEST(MessageText, TellsTextFromOctets) {
    EXPECT_TRUE(is_text(as_octets("gr\xc3\xbc\xc3\x9f")));
    EXPECT_FALSE(is_text(as_octets("\xff")));
    EXPECT_FALSE(is_text(as_octets("\x1b[2J")));
}

}  // namespace
}  // namespace romano::experiments::message_text_test
