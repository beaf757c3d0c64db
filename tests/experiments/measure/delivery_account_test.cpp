// Loss, duplicates and delays, on traces short enough to count by hand.

#include "experiments/measure/delivery_account.h"

#include <gtest/gtest.h>

namespace romano::experiments::delivery_account_test {
namespace {

const std::vector<RobotNumber> only_one = {1};
const std::vector<RobotNumber> three = {1, 2, 3};

TEST(DeliveryAccount, CountsAPairOnceHoweverManyCopiesArrive) {
    DeliveryAccount account;
    const auto sequence = account.on_published(0, Stream::one_to_one, 1, 1.0, only_one);
    EXPECT_TRUE(account.on_arrived(0, sequence, 1, 1.1));
    EXPECT_TRUE(account.on_arrived(0, sequence, 1, 1.2));
    EXPECT_TRUE(account.on_arrived(0, sequence, 1, 1.3));
    const DeliveryTally tally = account.tally_by_qos()[1];
    EXPECT_EQ(tally.expected, 1u);
    EXPECT_EQ(tally.delivered, 1u);
    EXPECT_EQ(tally.duplicates, 2u);
    EXPECT_EQ(tally.ratio(), 1.0);
}

TEST(DeliveryAccount, KeepsTheLevelsOfQosApart) {
    DeliveryAccount account;
    account.on_published(0, Stream::group, 0, 1.0, three);
    const auto second = account.on_published(0, Stream::group, 2, 2.0, three);
    account.on_arrived(0, second, 1, 2.5);
    const auto tallies = account.tally_by_qos();
    EXPECT_EQ(tallies[0].ratio(), 0.0);
    EXPECT_EQ(tallies[1].ratio(), std::nullopt);
    EXPECT_DOUBLE_EQ(tallies[2].ratio().value(), 1.0 / 3.0);
}

TEST(DeliveryAccount, OnlyAcknowledgedMessagesCanBeAcknowledgedButLost) {
    DeliveryAccount account;
    const auto promised = account.on_published(0, Stream::group, 1, 1.0, three);
    account.on_published(0, Stream::group, 1, 2.0, three);  // never acknowledged, never arrives
    account.on_acknowledged(0, promised, 1.2);
    account.on_arrived(0, promised, 2, 1.3);
    const DeliveryTally tally = account.tally_by_qos()[1];
    EXPECT_EQ(tally.published, 2u);
    EXPECT_EQ(tally.acknowledged, 1u);
    EXPECT_EQ(tally.acknowledged_but_lost, 2u);
    EXPECT_EQ(tally.expected - tally.delivered, 5u);
}

TEST(DeliveryAccount, SequencesCountEachPublisherFromZero) {
    DeliveryAccount account;
    EXPECT_EQ(account.on_published(4, Stream::group, 0, 0, three), 0u);
    EXPECT_EQ(account.on_published(4, Stream::group, 0, 0, three), 1u);
    EXPECT_EQ(account.on_published(2, Stream::group, 0, 0, three), 0u);
}

TEST(DeliveryAccount, WhatWasNeverPublishedToAReceiverIsAStray) {
    DeliveryAccount account;
    const auto sequence = account.on_published(0, Stream::one_to_one, 0, 1.0, only_one);
    EXPECT_FALSE(account.on_arrived(0, sequence, 2, 1.1));
    EXPECT_FALSE(account.on_arrived(0, sequence + 1, 1, 1.1));
    EXPECT_FALSE(account.on_arrived(9, 0, 1, 1.1));
    EXPECT_EQ(account.strays(), 3u);
    EXPECT_EQ(account.tally_by_qos()[0].delivered, 0u);
}

TEST(DeliveryAccount, OrderIsThatOfFirstCopiesWithinATopicAndQosOfOnePublisher) {
    DeliveryAccount account;
    for (int i = 0; i < 3; ++i) account.on_published(0, Stream::one_to_one, 1, 1.0 + i, only_one);
    const auto other_qos = account.on_published(0, Stream::one_to_one, 2, 4.0, only_one);
    const auto other_topic = account.on_published(0, Stream::group, 1, 5.0, three);
    account.on_arrived(0, other_topic, 1, 5.0);
    account.on_arrived(0, other_qos, 1, 5.1);
    account.on_arrived(0, 2, 1, 5.2);
    account.on_arrived(0, 0, 1, 5.3);  // overtaken by message 2
    account.on_arrived(0, 1, 1, 5.4);  // too
    account.on_arrived(0, 0, 1, 5.5);  // a copy
    EXPECT_EQ(account.tally_by_qos()[1].out_of_order, 2u);
    EXPECT_EQ(account.tally_by_qos()[2].out_of_order, 0u);
}

TEST(DeliveryAccount, DelayIsFromSendToTheFirstCopy) {
    DeliveryAccount account;
    const auto sequence = account.on_published(0, Stream::group, 1, 1.0, three);
    account.on_arrived(0, sequence, 1, 1.010);
    account.on_arrived(0, sequence, 1, 1.500);
    account.on_arrived(0, sequence, 3, 1.030);
    const Percentiles delays = account.delays_ms();
    EXPECT_EQ(delays.count(), 2u);
    EXPECT_NEAR(delays.min().value(), 10, 1e-6);
    EXPECT_NEAR(delays.max().value(), 30, 1e-6);
}

TEST(DeliveryAccount, FanOutDelayIsToTheLastReceiverOfACompleteGroup) {
    DeliveryAccount account;
    const auto complete = account.on_published(0, Stream::group, 0, 1.0, three);
    account.on_arrived(0, complete, 2, 1.001);
    account.on_arrived(0, complete, 1, 1.004);
    account.on_arrived(0, complete, 3, 1.002);
    const auto partial = account.on_published(0, Stream::group, 0, 2.0, three);
    account.on_arrived(0, partial, 1, 2.9);
    const auto single = account.on_published(0, Stream::one_to_one, 0, 3.0, only_one);
    account.on_arrived(0, single, 1, 3.9);
    const Percentiles delays = account.fan_out_delays_ms();
    EXPECT_EQ(delays.count(), 1u);
    EXPECT_NEAR(delays.max().value(), 4, 1e-6);
}

TEST(DeliveryAccount, IsSettledWhenAllOfQos1And2IsAcknowledgedAndDelivered) {
    DeliveryAccount account;
    EXPECT_TRUE(account.is_settled());
    account.on_published(0, Stream::one_to_one, 0, 1.0, only_one);
    EXPECT_TRUE(account.is_settled());
    const auto sequence = account.on_published(0, Stream::one_to_one, 1, 1.0, only_one);
    EXPECT_FALSE(account.is_settled());
    account.on_arrived(0, sequence, 1, 1.1);
    account.on_arrived(0, sequence, 1, 1.2);
    EXPECT_FALSE(account.is_settled());
    account.on_acknowledged(0, sequence, 1.3);
    account.on_acknowledged(0, sequence, 1.4);
    EXPECT_TRUE(account.is_settled());
}

}  // namespace
}  // namespace romano::experiments::delivery_account_test
