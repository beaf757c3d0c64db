// A receiver that takes messages more slowly than robots at another broker publish them.

#include <gmock/gmock.h>

#include <chrono>

#include "overlay/member/member.h"
#include "tests/overlay/member/steps.h"

namespace romano::test::slow_receiver_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;
using testing::SizeIs;

class SlowReceiver : public testing::TestWithParam<Qos> {};

TEST_P(SlowReceiver, P1_ItsPublishersAtAnotherBrokerGoAtItsPaceAndNothingIsLost) {
    constexpr int publishers = 6;
    constexpr int each = 400;
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& receiver = subscriber(brokers, "receiver", 1, GetParam());
    for (int n = 0; n < publishers; ++n) {
        Robot& robot = publisher(brokers, "p" + std::to_string(n), 2);
        for (const auto& text : numbers(1, each)) robot.publish("pose", text, GetParam());
    }
    brokers.run_for(30s);
    EXPECT_THAT(receiver.received(), SizeIs(publishers * each));
    EXPECT_GT(brokers.member(2).broker().counters().late_answers, 0U);
}

INSTANTIATE_TEST_SUITE_P(Qos, SlowReceiver, testing::Values(Qos::at_least_once, Qos::exactly_once));

TEST(SlowReceiverAtAPeer, DoesNotHoldUpWhoPublishesForOthers) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    subscriber(brokers, "receiver", 1, Qos::at_least_once);
    for (int n = 0; n < 6; ++n) {
        Robot& robot = publisher(brokers, "p" + std::to_string(n), 2);
        for (const auto& text : numbers(1, 400)) robot.publish("pose", text, Qos::at_least_once);
    }
    brokers.run_for(2s);
    ASSERT_GT(brokers.member(2).broker().counters().late_answers, 0U);
    Robot& other = publisher(brokers, "other", 2);
    for (const auto& text : numbers(1, 100)) other.publish("map", text, Qos::at_least_once);
    brokers.run_for(1s);
    EXPECT_EQ(other.acknowledged(), 100U);
}

}  // namespace
}  // namespace romano::test::slow_receiver_test
