#include "firmware/hdlc/link.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <vector>

#include "romano/base/random.h"

namespace romano::hdlc::link_test {
namespace {

using namespace std::chrono_literals;
using Octets = std::vector<std::uint8_t>;

constexpr Instant start{};

Octets drain(Link& link) {
    Octets octets{link.line_out().begin(), link.line_out().end()};
    link.clear_line_out();
    return octets;
}

std::vector<Octets> feed(Link& link, const Octets& line) {
    std::vector<Octets> delivered;
    for (const std::uint8_t octet : line) {
        if (const auto data = link.on_octet(start, octet))
            delivered.push_back({data->begin(), data->end()});
    }
    return delivered;
}

TEST(Link, DeliversAndAcknowledges) {
    Link controller;
    Link radio;
    ASSERT_TRUE(controller.send(start, Octets{1, 2, 3}));
    EXPECT_FALSE(controller.is_idle());
    EXPECT_EQ(feed(radio, drain(controller)), (std::vector<Octets>{{1, 2, 3}}));
    feed(controller, drain(radio));
    EXPECT_TRUE(controller.is_idle());
    EXPECT_EQ(controller.next_wakeup(), never);
}

TEST(Link, OneFrameIsInFlightAtATime) {
    Link link;
    ASSERT_TRUE(link.send(start, Octets{1}));
    EXPECT_FALSE(link.send(start, Octets{2}));
}

TEST(Link, RepeatsWithoutLimitUntilAcknowledged) {
    Link link(100ms);
    ASSERT_TRUE(link.send(start, Octets{1}));
    const Octets first = drain(link);
    for (int i = 1; i <= 50; ++i) {
        EXPECT_EQ(link.next_wakeup(), start + i * 100ms);
        link.on_tick(start + i * 100ms - 1ns);
        EXPECT_TRUE(drain(link).empty()) << "too early";
        link.on_tick(start + i * 100ms);
        EXPECT_EQ(drain(link), first);
    }
    EXPECT_EQ(link.repeats(), 50U);
}

TEST(Link, ARepeatedFrameIsAcknowledgedButDeliveredOnce) {
    Link sender(100ms);
    Link receiver;
    ASSERT_TRUE(sender.send(start, Octets{9}));
    const Octets frame = drain(sender);
    EXPECT_EQ(feed(receiver, frame).size(), 1U);
    const Octets lost_ack = drain(receiver);
    EXPECT_TRUE(feed(receiver, frame).empty());
    EXPECT_EQ(drain(receiver), lost_ack);
}

TEST(Link, AFrameFarFromTheExpectedNumberIsNeitherAcknowledgedNorDelivered) {
    Link receiver;
    Octets line(max_encoded);
    line.resize(encode({FrameKind::data, 4, {}}, line));
    EXPECT_TRUE(feed(receiver, line).empty());
    EXPECT_TRUE(drain(receiver).empty());
}

TEST(Link, ANackCountsAsAnAckAndOneForAnotherFrameCountsForNothing) {
    Link sender;
    ASSERT_TRUE(sender.send(start, Octets{1}));
    drain(sender);
    Octets nack(max_encoded);
    nack.resize(encode({FrameKind::nack, 1, {}}, nack));
    feed(sender, nack);
    EXPECT_FALSE(sender.is_idle());
    nack.resize(max_encoded);
    nack.resize(encode({FrameKind::nack, 0, {}}, nack));
    feed(sender, nack);
    EXPECT_TRUE(sender.is_idle());
}

TEST(Link, DeliversEverythingInOrderOverALineThatLosesAndBendsOctets) {
    const std::uint64_t seed = 115200;
    Random random(seed);
    Link sender(10ms);
    Link receiver(10ms);
    Instant now = start;
    std::vector<Octets> sent;
    std::vector<Octets> received;
    const auto noisy = [&random](Octets line) {
        for (auto& octet : line) {
            if (random.happens(5'000)) octet ^= static_cast<std::uint8_t>(1U << random.below(8));
        }
        if (random.happens(50'000)) line.clear();
        return line;
    };
    while (sent.size() < 2'000 || !sender.is_idle()) {
        ASSERT_LT(now, start + 600s) << "no progress, seed " << seed;
        if (sender.is_idle()) {
            Octets data(random.below(max_data) + 1);
            for (auto& octet : data) octet = static_cast<std::uint8_t>(random.below(256));
            ASSERT_TRUE(sender.send(now, data));
            sent.push_back(data);
        }
        for (Octets& data : feed(receiver, noisy(drain(sender))))
            received.push_back(std::move(data));
        feed(sender, noisy(drain(receiver)));
        now += 1ms;
        sender.on_tick(now);
    }
    EXPECT_EQ(received, sent) << "seed " << seed;
    EXPECT_GT(sender.repeats(), 100U);
}

}  // namespace
}  // namespace romano::hdlc::link_test
