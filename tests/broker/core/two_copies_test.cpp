#include "broker/core/two_copies.h"

#include <gmock/gmock.h>

#include <utility>

namespace romano::broker::two_copies_test {
namespace {

using testing::ElementsAre;

const LogId talker{broker_id_of("talker"), 1};

MessagePtr message(Seq seq) {
    return MessagePtr{Message{.topic = "pose",
                              .payload = {},
                              .qos = mqttsn::Qos::exactly_once,
                              .position = {talker, seq},
                              .published_at = {}}};
}

Delivery delivery(Seq seq, DeliveryStage stage, mqttsn::MsgId msg_id = mqttsn::no_msg_id) {
    return {.position = {talker, seq},
            .message = message(seq),
            .qos = mqttsn::Qos::exactly_once,
            .stage = stage,
            .msg_id = msg_id};
}

std::vector<Seq> numbers(const std::vector<MessagePtr>& messages) {
    std::vector<Seq> seqs;
    for (const auto& m : messages) seqs.push_back(m->position.seq);
    return seqs;
}

std::vector<Seq> numbers(const std::vector<Delivery>& deliveries) {
    std::vector<Seq> seqs;
    for (const auto& d : deliveries) seqs.push_back(d.position.seq);
    return seqs;
}

constexpr mqttsn::MsgId sent{7};

/// The copy that wins has waited with 2 to 4 and knows nothing of 5 to 7. The other home had worked
/// through 6, and has 4 left to do.
struct TwoCopies : testing::Test {
    TwoCopies() {
        other.header.clean = false;
        other.subscriptions = {{.filter = "pose", .granted = mqttsn::Qos::exactly_once}};
        other.worked_through = {{talker, 6}};
        other.deliveries = {delivery(4, DeliveryStage::queued)};
        winner.header.epoch = other.header.epoch + 1;
        winner.deliveries = {delivery(2, DeliveryStage::released),
                             delivery(3, DeliveryStage::published, sent),
                             delivery(4, DeliveryStage::queued)};
    }

    SessionImage other;
    SessionImage winner;
    std::vector<MessagePtr> missed{message(5), message(6), message(7)};
};

HybridTime at_second(std::uint64_t second) {
    return {(second * 1000) << 16U};
}

// P7: its broker was cut off when the client died, and said no will, for it might be elsewhere.
TEST_F(TwoCopies, P7_WhoWasLostAtTheOtherHomeAndSilentHereIsNotLostTwice) {
    winner.header.keep_alive_s = 10;
    winner.header.last_heard = at_second(100);
    other.header.state = SessionState::lost;
    other.header.departed = at_second(115);
    const Settled settled = settle(winner, other, missed);
    EXPECT_FALSE(settled.comes);
    EXPECT_TRUE(settled.is_new);
    EXPECT_EQ(settled.image.header.state, SessionState::lost);
    EXPECT_EQ(settled.image.header.departed, at_second(115));
}

TEST_F(TwoCopies, WhoWasLostAtTheOtherHomeAndHeardHereLives) {
    winner.header.keep_alive_s = 10;
    winner.header.last_heard = at_second(106);
    other.header.state = SessionState::lost;
    other.header.departed = at_second(115);
    EXPECT_EQ(settle(winner, other, missed).image.header.state, SessionState::active);
}

TEST_F(TwoCopies, P3_WhatTheFormerHomeDeliveredIsLeftOut) {
    const Settled settled = settle(other, winner, missed);
    EXPECT_TRUE(settled.comes);
    EXPECT_THAT(numbers(missed), ElementsAre(7));
    EXPECT_THAT(numbers(settled.image.deliveries), ElementsAre(2, 4));  // 2 waits for its PUBCOMP
    EXPECT_EQ(settled.unfinished, sent);
}

// The client was at the home that loses for a moment, after the heal (simulator, seed 1114317).
TEST_F(TwoCopies, P3_WhatTheOtherHomeDeliveredIsLeftOutOfTheCopyThatStays) {
    missed.clear();
    const Settled settled = settle(winner, other, missed);
    EXPECT_FALSE(settled.comes);
    EXPECT_TRUE(settled.is_new);
    EXPECT_THAT(numbers(settled.image.deliveries), ElementsAre(2, 4));
    EXPECT_EQ(settled.unfinished, sent);
}

// It may have left already, and the copy that comes would send it anew (simulator, seed 1120970).
TEST_F(TwoCopies, P3_WhatTheFormerHomeHasBegunAndTheOtherOneMissedGoesOnUnderItsId) {
    other.deliveries.push_back(delivery(6, DeliveryStage::published, sent));
    const Settled settled = settle(other, winner, missed);
    EXPECT_THAT(numbers(missed), ElementsAre(7));
    ASSERT_THAT(numbers(settled.image.deliveries), ElementsAre(2, 4, 6));
    EXPECT_EQ(settled.image.deliveries.back().msg_id, sent);
    EXPECT_EQ(settled.image.deliveries.back().stage, DeliveryStage::published);
}

// It was closed there by PUBREL, and then came again from here.
TEST_F(TwoCopies, P3_WhatTheClientReceivedFromTheOtherHomeIsNotRepeatedUnderTheOwnId) {
    constexpr mqttsn::MsgId theirs{9};
    missed.clear();
    other.deliveries.push_back(delivery(3, DeliveryStage::released, theirs));
    const Settled settled = settle(winner, other, missed);
    ASSERT_THAT(numbers(settled.image.deliveries), ElementsAre(2, 3, 4));
    EXPECT_EQ(settled.image.deliveries[1].stage, DeliveryStage::released);
    EXPECT_EQ(settled.image.deliveries[1].msg_id, theirs);
    EXPECT_EQ(settled.unfinished, sent);
    EXPECT_TRUE(settled.is_new);
}

TEST_F(TwoCopies, WhatTellsNothingNewLeavesTheOwnCopyAsItIs) {
    other.worked_through.clear();
    missed.clear();
    const Settled settled = settle(winner, other, missed);
    EXPECT_FALSE(settled.comes);
    EXPECT_FALSE(settled.is_new);
}

// The client says it again, with DUP, to the home that stays (simulator, seed 1403805).
TEST_F(TwoCopies, P3_WhatTheClientPublishedLastAtTheOtherHomeIsPublished) {
    winner.unreleased = {mqttsn::MsgId{1}, mqttsn::MsgId{2}};
    other.unreleased = {mqttsn::MsgId{2}, mqttsn::MsgId{3}};
    other.header.last_published = HybridTime{2};
    winner.header.last_published = HybridTime{1};
    winner.header.last_heard = HybridTime{3};  // it answered what was sent to it
    EXPECT_THAT(settle(winner, other, missed).image.unreleased,
                ElementsAre(mqttsn::MsgId{1}, mqttsn::MsgId{2}, mqttsn::MsgId{3}));
    // Of an older copy the client may have released it since, and use the id anew.
    other.header.last_published = HybridTime{};
    EXPECT_THAT(settle(winner, other, missed).image.unreleased,
                ElementsAre(mqttsn::MsgId{1}, mqttsn::MsgId{2}));
}

TEST_F(TwoCopies, P2_WhatWasNotForTheSessionAtItsFormerHomeWasNotDelivered) {
    other.subscriptions = {{.filter = "map", .granted = mqttsn::Qos::exactly_once},
                           {.filter = "pose", .granted = mqttsn::Qos::at_most_once}};
    const Settled settled = settle(other, winner, missed);
    EXPECT_THAT(numbers(missed), ElementsAre(5, 6, 7));
    EXPECT_THAT(numbers(settled.image.deliveries), ElementsAre(2, 3, 4));
}

// Nothing waits for a clean session whose client said goodbye.
TEST_F(TwoCopies, P2_AFormerHomeThatTheClientHadLeftDeliveredNothing) {
    other.header.clean = true;
    other.header.state = SessionState::disconnected;
    const Settled settled = settle(other, winner, missed);
    EXPECT_THAT(numbers(missed), ElementsAre(5, 6, 7));
    EXPECT_THAT(numbers(settled.image.deliveries), ElementsAre(2, 3, 4));
}

}  // namespace
}  // namespace romano::broker::two_copies_test
