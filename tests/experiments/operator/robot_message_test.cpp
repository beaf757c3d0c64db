#include "experiments/operator/robot_message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace romano::experiments::robot_message_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string text(const Octets& octets) {
    return {octets.begin(), octets.end()};
}

template <typename Call>
std::string refusal(Call&& call) {
    try {
        (void)call();
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "accepted";
}

std::string move_refusal(Form form, std::string_view movement, std::string_view amount) {
    return refusal([&] { return move_message(form, movement, amount, 30); });
}

TEST(RobotMessage, MovesAreMillimetresAndMillidegrees) {
    EXPECT_THAT(move_message(Form::binary, "front", "100mm", 0),
                ElementsAre(0x07, 0x08, 0, 0, 0, 0, 0, 100));
    EXPECT_THAT(move_message(Form::binary, "right", "1.5m", 0),
                ElementsAre(0x07, 0x08, 0, 3, 0, 0, 0x05, 0xDC));
    EXPECT_THAT(move_message(Form::binary, "rotate-left", "90deg", 0),
                ElementsAre(0x07, 0x08, 0, 4, 0, 0x01, 0x5F, 0x90));
    EXPECT_EQ(move_message(Form::binary, "back", "10cm", 0),
              move_message(Form::binary, "back", "100mm", 0));
}

TEST(RobotMessage, AnApplicationsOwnMovementTakesItsOctets) {
    EXPECT_THAT(move_message(Form::binary, "0x8001", "0a0b", 0),
                ElementsAre(0x07, 0x06, 0x80, 0x01, 0x0A, 0x0B));
    EXPECT_THAT(move_refusal(Form::binary, "0x8001", "0a0"), HasSubstr("hexadecimal"));
}

TEST(RobotMessage, WhatIsNoMovementIsRefusedWithWhatIsAllowed) {
    EXPECT_THAT(move_refusal(Form::binary, "up", "1m"), HasSubstr("front, back"));
    EXPECT_THAT(move_refusal(Form::binary, "front", "1"), HasSubstr("100mm"));
    EXPECT_THAT(move_refusal(Form::binary, "front", "90deg"), HasSubstr("distance"));
    EXPECT_THAT(move_refusal(Form::binary, "rotate-left", "10mm"), HasSubstr("angle"));
    EXPECT_THAT(move_refusal(Form::binary, "front", "-1mm"), HasSubstr("from 0"));
    EXPECT_THAT(move_refusal(Form::binary, "front", "5000000000mm"), HasSubstr("from 0"));
    EXPECT_THAT(move_refusal(Form::binary, "front", "nanmm"), HasSubstr("`nanmm`"));
}

TEST(RobotMessage, TheAuthorsFirmwareMovesByTimeAndDegrees) {
    EXPECT_EQ(text(move_message(Form::legacy, "front", "500ms", 30)), "70401f400001e");
    EXPECT_EQ(text(move_message(Form::legacy, "back", "1s", 30)), "70403e80000e2");
    EXPECT_EQ(text(move_message(Form::legacy, "rotate-left", "90deg", 30)), "7020000005a1e");
    EXPECT_EQ(text(move_message(Form::legacy, "rotate-right", "90deg", 30)), "7020000ffa61e");
    EXPECT_THAT(move_refusal(Form::legacy, "front", "100mm"), HasSubstr("drives by time"));
    EXPECT_THAT(move_refusal(Form::legacy, "left", "1s"), HasSubstr("sideways"));
}

TEST(RobotMessage, SubscriptionsAndRequestsInBothForms) {
    EXPECT_THAT(subscribe_message(Form::binary, "line"), ElementsAre(1, 6, 'l', 'i', 'n', 'e'));
    EXPECT_EQ(text(subscribe_message(Form::legacy, "line")), "1line");
    EXPECT_THAT(unsubscribe_message(Form::binary, "l"), ElementsAre(9, 3, 'l'));
    EXPECT_THAT(request_message(Form::binary, "tel", "ir"),
                ElementsAre(2, 8, 5, 't', 'e', 'l', 'i', 'r'));
    EXPECT_EQ(text(request_message(Form::legacy, "telemetry2", "ir")), "2:telemetry20ir");
}

TEST(RobotMessage, TheAuthorsFirmwareIsNotSentWhatItCannotTake) {
    EXPECT_THAT(refusal([] { return subscribe_message(Form::legacy, "a/topic/of/sixte"); }),
                HasSubstr("15 octets"));
    EXPECT_THAT(refusal([] { return unsubscribe_message(Form::legacy, "a"); }),
                HasSubstr("cannot unsubscribe"));
    EXPECT_THAT(refusal([] { return request_message(Form::legacy, "t", std::string(40, 'x')); }),
                HasSubstr("31 octets"));
}

TEST(RobotMessage, WhatIsNoTopicIsRefusedBeforeARobotHearsOfIt) {
    EXPECT_THAT(refusal([] { return subscribe_message(Form::binary, "a/#/b"); }),
                HasSubstr("topic `a/#/b`"));
    EXPECT_THAT(refusal([] { return unsubscribe_message(Form::binary, ""); }),
                HasSubstr("not empty"));
    EXPECT_THAT(subscribe_message(Form::binary, "a/+"), ElementsAre(1, 5, 'a', '/', '+'));
    EXPECT_THAT(refusal([] { return request_message(Form::binary, "a/+", "location"); }),
                HasSubstr("without + and #"));
}

TEST(RobotMessage, ReceiversAreIdsInLowerCaseOrTopics) {
    EXPECT_THAT(receivers_in("abcd1234,team/red"), ElementsAre("abcd1234", "team/red"));
    EXPECT_THAT(refusal([] { return receivers_in("ABCD1234"); }),
                HasSubstr("lower case: abcd1234"));
    EXPECT_THAT(refusal([] { return receivers_in("team/#"); }), HasSubstr("robot `team/#`"));
    EXPECT_THAT(refusal([] { return receivers_in(""); }), HasSubstr("not empty"));
    EXPECT_THAT(refusal([] { return receivers_in("a,,b"); }), HasSubstr("not empty"));
}

}  // namespace
}  // namespace romano::experiments::robot_message_test
