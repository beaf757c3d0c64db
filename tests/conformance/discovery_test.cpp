// Section 6.1: searching for a gateway. That GWINFO and ADVERTISE also go to the network's group is
// a matter of the transport.

#include "tests/conformance/suite.h"

namespace romano::conformance::discovery_test {
namespace {

CONFORMANCE_SUITE(S6_1_Discovery, PatientSuite);

TEST_P(S6_1_Discovery, b_SearchgwIsAnsweredByGwinfoWithoutAddress) {
    Client& robot = client();
    robot.says(searchgw(1));
    const Octets answer = robot.next();
    ASSERT_EQ(answer.size(), 3u) << describe(answer);
    EXPECT_EQ(answer[1], 0x02);
}

TEST_P(S6_1_Discovery, b_AnyRadiusIsAnsweredAndTheGatewayIdStaysTheSame) {
    Client& robot = client();
    robot.says(searchgw(0));
    const Octets first = robot.next();
    robot.says(searchgw(255));
    EXPECT_EQ(robot.next(), first);
}

TEST_P(S6_1_Discovery, SearchingNeedsNoSessionAndDisturbsNone) {
    Client& robot = connected();
    robot.says(searchgw(1));
    EXPECT_EQ(robot.next().size(), 3u);
    robot.says(pingreq());
    robot.hears(pingresp());
}

TEST_P(S6_1_Discovery, c_WhatOtherGatewaysSayIsNotAnswered) {
    Client& other = client();
    other.says(Body{}.u8(9).u16(900).as(Msg::advertise));
    other.says(Body{}.u8(9).as(Msg::gwinfo));
    other.says(Body{}.u8(9).text("\x7F\x01\x01\x01").as(Msg::gwinfo));
    hears_nothing(other);
}

}  // namespace
}  // namespace romano::conformance::discovery_test
