#include "overlay/cluster/adoption.h"

#include <gmock/gmock.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster {
namespace {

using testing::ElementsAre;

const LogId talker = test::log_of("talker");

MessagePtr message(Seq seq) {
    return std::get<broker::Published>(test::published(talker, seq, "pose")).message;
}

broker::Delivery delivery(Seq seq, broker::DeliveryStage stage) {
    return {.position = {talker, seq}, .message = message(seq), .stage = stage};
}

std::vector<Seq> numbers(const std::vector<MessagePtr>& messages) {
    std::vector<Seq> seqs;
    for (const auto& m : messages) seqs.push_back(m->position.seq);
    return seqs;
}

std::vector<Seq> numbers(const std::vector<broker::Delivery>& deliveries) {
    std::vector<Seq> seqs;
    for (const auto& d : deliveries) seqs.push_back(d.position.seq);
    return seqs;
}

/// The copy that wins has waited with 2 to 4 and knows nothing of 5 to 7. The former home had
/// worked through 6, and has 4 left to do.
struct TwoHomes {
    TwoHomes() {
        former.header.clean = false;
        former.subscriptions = {{.filter = "pose", .granted = mqttsn::Qos::exactly_once}};
        former.worked_through = {{talker, 6}};
        former.deliveries = {delivery(4, broker::DeliveryStage::queued)};
        winner.deliveries = {delivery(2, broker::DeliveryStage::released),
                             delivery(3, broker::DeliveryStage::published),
                             delivery(4, broker::DeliveryStage::queued)};
    }

    broker::SessionImage former;
    broker::SessionImage winner;
    std::vector<MessagePtr> missed{message(5), message(6), message(7)};
};

TEST(Adoption, P3_WhatTheFormerHomeDeliveredIsLeftOut) {
    TwoHomes homes;
    leave_out_delivered(homes.winner, homes.missed, homes.former);
    EXPECT_THAT(numbers(homes.missed), ElementsAre(7));
    EXPECT_THAT(numbers(homes.winner.deliveries), ElementsAre(2, 4));  // 2 waits for its PUBCOMP
}

TEST(Adoption, P2_WhatWasNotForTheSessionAtItsFormerHomeWasNotDelivered) {
    TwoHomes homes;
    homes.former.subscriptions = {{.filter = "map", .granted = mqttsn::Qos::exactly_once},
                                  {.filter = "pose", .granted = mqttsn::Qos::at_most_once}};
    leave_out_delivered(homes.winner, homes.missed, homes.former);
    EXPECT_THAT(numbers(homes.missed), ElementsAre(5, 6, 7));
    EXPECT_THAT(numbers(homes.winner.deliveries), ElementsAre(2, 3, 4));
}

// Nothing waits for a clean session whose client said goodbye.
TEST(Adoption, P2_AFormerHomeThatTheClientHadLeftDeliveredNothing) {
    TwoHomes homes;
    homes.former.header.clean = true;
    homes.former.header.state = broker::SessionState::disconnected;
    leave_out_delivered(homes.winner, homes.missed, homes.former);
    EXPECT_THAT(numbers(homes.missed), ElementsAre(5, 6, 7));
    EXPECT_THAT(numbers(homes.winner.deliveries), ElementsAre(2, 3, 4));
}

}  // namespace
}  // namespace romano::cluster
