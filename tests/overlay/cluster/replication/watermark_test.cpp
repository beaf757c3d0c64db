#include "overlay/cluster/replication/watermark.h"

#include <gtest/gtest.h>

#include <array>

#include "overlay/cluster/options.h"
#include "tests/overlay/cluster/events.h"

namespace romano::cluster::watermark_test {
namespace {

const std::array peers = {test::log_of("b1"), test::log_of("b2"), test::log_of("b3")};

Watermark after_acks(std::uint32_t acks) {
    Watermark watermark(acks);
    watermark.on_ack(peers[0], 3);
    watermark.on_ack(peers[1], 7);
    watermark.on_ack(peers[2], 5);
    return watermark;
}

TEST(Watermark, OnePeerIsEnoughByDefault) {
    EXPECT_EQ(after_acks(1).advance(10, peers, 1), 7U);
}

TEST(Watermark, ManyPeersAsAskedFor) {
    EXPECT_EQ(after_acks(2).advance(10, peers, 1), 5U);
    EXPECT_EQ(after_acks(all_peers).advance(10, peers, 1), 3U);
}

TEST(Watermark, ZeroWaitsForNobody) {
    EXPECT_EQ(after_acks(0).advance(10, peers, 1), 10U);
}

TEST(Watermark, NobodyInViewIsWaitedFor) {
    EXPECT_EQ(after_acks(1).advance(10, {}, 2), 10U);
}

TEST(Watermark, AShrunkenViewWaitsForThoseThatAreLeft) {
    Watermark watermark = after_acks(all_peers);
    EXPECT_EQ(watermark.advance(10, peers, 1), 3U);
    EXPECT_EQ(watermark.advance(10, std::span(peers).subspan(1), 3), 5U);
}

TEST(Watermark, NeverFalls) {
    Watermark watermark = after_acks(1);
    EXPECT_EQ(watermark.advance(10, {}, 2), 10U);
    EXPECT_EQ(watermark.advance(12, peers, 1), 10U);
}

TEST(Watermark, AnAckBeyondTheOwnLogIsCut) {
    Watermark watermark(1);
    watermark.on_ack(peers[0], 99);
    EXPECT_EQ(watermark.advance(10, peers, 1), 10U);
}

TEST(Watermark, APeerThatLetOurLogGoDoesNotHoldIt) {
    Watermark watermark = after_acks(1);
    EXPECT_EQ(watermark.advance(7, peers, 1), 7U);
    for (const auto& peer : peers) watermark.on_beacon(peer, 0);
    for (const auto& peer : peers) EXPECT_EQ(watermark.held_by(peer), 0U);
    EXPECT_EQ(watermark.advance(10, peers, 1), 7U);
    watermark.on_beacon(peers[0], 9);
    EXPECT_EQ(watermark.advance(10, peers, 1), 9U);
}

TEST(Watermark, KnowsWhenSomethingWasPromisedThatNobodyHolds) {
    Watermark watermark = after_acks(1);
    (void)watermark.advance(10, peers, 1);
    for (const auto& peer : peers) watermark.on_beacon(peer, 0);
    EXPECT_FALSE(watermark.has_promised_alone()) << "they held it once, and know its end";
    (void)watermark.advance(10, {}, 2);
    EXPECT_TRUE(watermark.has_promised_alone());
    watermark.on_ack(peers[0], 10);
    EXPECT_FALSE(watermark.has_promised_alone());
}

}  // namespace
}  // namespace romano::cluster::watermark_test
