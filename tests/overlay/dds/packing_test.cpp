#include "overlay/dds/packing.h"

#include <gtest/gtest.h>

namespace romano::dds::packing_test {
namespace {

using broker::BrokerId;
using broker::LogId;

const LogId own{BrokerId{1}, 1};
const LogId other{BrokerId{2}, 1};

overlay::Outgoing batch(broker::Seq first, std::size_t events, std::size_t payload = 0) {
    cluster::LogBatch out{.log = own, .first_seq = first};
    for (std::size_t i = 0; i < events; ++i) {
        broker::Message message;
        message.payload.resize(payload);
        out.events.push_back(broker::Published{broker::MessagePtr{message}, "", {}, {}});
    }
    return {std::nullopt, std::move(out)};
}

overlay::Outgoing forward(BrokerId to, const char* topic) {
    broker::Message message;
    message.topic = topic;
    return {to, cluster::ForwardBatch{{broker::MessagePtr{message}}}};
}

template <typename M>
const M& at(const std::vector<overlay::Outgoing>& messages, std::size_t i) {
    return std::get<M>(messages.at(i).message);
}

TEST(Packing, JoinsConsecutiveLogBatches) {
    std::vector messages{batch(1, 2), batch(3, 1), batch(4, 5)};
    pack(messages);
    ASSERT_EQ(messages.size(), 1U);
    EXPECT_EQ(at<cluster::LogBatch>(messages, 0).first_seq, 1U);
    EXPECT_EQ(at<cluster::LogBatch>(messages, 0).events.size(), 8U);
}

TEST(Packing, LeavesAGapBetweenLogBatches) {
    std::vector messages{batch(1, 2), batch(4, 1)};
    pack(messages);
    EXPECT_EQ(messages.size(), 2U);
}

TEST(Packing, KeepsSamplesOfAReasonableSize) {
    std::vector messages{batch(1, 1, 40'000), batch(2, 1, 40'000), batch(3, 1, 100)};
    pack(messages);
    ASSERT_EQ(messages.size(), 2U);
    EXPECT_EQ(at<cluster::LogBatch>(messages, 1).events.size(), 2U);
}

TEST(Packing, JoinsForwardsToOnePeerInOrder) {
    std::vector messages{forward(BrokerId{2}, "a"), forward(BrokerId{3}, "b"),
                         forward(BrokerId{2}, "c")};
    pack(messages);
    ASSERT_EQ(messages.size(), 2U);
    const auto& joined = at<cluster::ForwardBatch>(messages, 0).messages;
    ASSERT_EQ(joined.size(), 2U);
    EXPECT_EQ(joined[0]->topic, "a");
    EXPECT_EQ(joined[1]->topic, "c");
}

TEST(Packing, OfSeveralAcknowledgementsTheLastSaysAll) {
    const auto ack = [](const LogId& log, broker::Seq seq) {
        return overlay::Outgoing{BrokerId{2}, cluster::LogAck{{log, seq}, own}};
    };
    std::vector messages{ack(other, 3), ack(own, 7), ack(other, 9)};
    pack(messages);
    // Another log's acknowledgement stands between: nothing is joined across it.
    EXPECT_EQ(messages.size(), 3U);
    messages = {ack(other, 3), ack(other, 5), ack(other, 9)};
    pack(messages);
    ASSERT_EQ(messages.size(), 1U);
    EXPECT_EQ(at<cluster::LogAck>(messages, 0).through.seq, 9U);
}

TEST(Packing, LeavesOtherMessagesAsTheyAre) {
    std::vector<overlay::Outgoing> messages{{std::nullopt, cluster::Heartbeat{}},
                                            {std::nullopt, cluster::Heartbeat{}},
                                            {BrokerId{2}, cluster::SessionRequest{"a", {}}},
                                            {BrokerId{2}, cluster::SessionRequest{"a", {}}}};
    pack(messages);
    EXPECT_EQ(messages.size(), 4U);
}

}  // namespace
}  // namespace romano::dds::packing_test
