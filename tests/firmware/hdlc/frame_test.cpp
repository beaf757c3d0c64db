#include "firmware/hdlc/frame.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "romano/base/random.h"

namespace romano::hdlc::frame_test {
namespace {

using Octets = std::vector<std::uint8_t>;

Octets encoded(const Frame& frame) {
    Octets out(max_encoded);
    out.resize(encode(frame, out));
    return out;
}

struct Copy {
    FrameKind kind;
    std::uint8_t seq;
    Octets data;
};

std::vector<Copy> decoded(FrameDecoder& decoder, const Octets& line) {
    std::vector<Copy> frames;
    for (const std::uint8_t octet : line) {
        if (const auto frame = decoder.on_octet(octet)) {
            frames.push_back({frame->kind, frame->seq, {frame->data.begin(), frame->data.end()}});
        }
    }
    return frames;
}

TEST(Frame, ChecksumIsCrc16X25) {
    EXPECT_EQ(fcs16(as_octets("123456789")), 0x906E);
}

TEST(Frame, MatchesTheAuthorsFirmwareOctetByOctet) {
    EXPECT_EQ(encoded({FrameKind::ack, 0, {}}), (Octets{0x7E, 0xFF, 0x01, 0x0E, 0xE1, 0x7E}));
    EXPECT_EQ(encoded({FrameKind::ack, 1, {}}), (Octets{0x7E, 0xFF, 0x21, 0x0C, 0xC0, 0x7E}));
    const Octets mqtt_go{0xAA, 0x00, 0xC8, 0x00, 0x09};
    EXPECT_EQ(encoded({FrameKind::data, 0, mqtt_go}),
              (Octets{0x7E, 0xFF, 0x10, 0xAA, 0x00, 0xC8, 0x00, 0x09, 0x90, 0xB7, 0x7E}));
}

TEST(Frame, FlagsAndEscapesInsideAreStuffed) {
    const Octets data{0x7E, 0x7D, 0x20};
    const Octets line = encoded({FrameKind::data, 3, data});
    EXPECT_EQ((Octets{line.begin() + 3, line.begin() + 8}), (Octets{0x7D, 0x5E, 0x7D, 0x5D, 0x20}));
    FrameDecoder decoder;
    const auto frames = decoded(decoder, line);
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].seq, 3);
    EXPECT_EQ(frames[0].data, data);
}

TEST(Frame, HoldsAtMost64OctetsOfData) {
    const Octets full(64, 0x7E);
    const Octets line = encoded({FrameKind::data, 7, full});
    EXPECT_LE(line.size(), max_encoded);
    FrameDecoder decoder;
    EXPECT_EQ(decoded(decoder, line).at(0).data, full);
    EXPECT_TRUE(encoded({FrameKind::data, 0, Octets(65)}).empty());
}

TEST(FrameDecoder, SkipsExtraFlagsAndOctetsBeforeTheFirstFlag) {
    FrameDecoder decoder;
    Octets line{0x01, 0x02, 0x7E, 0x7E, 0x7E};
    const Octets ack = encoded({FrameKind::ack, 2, {}});
    line.insert(line.end(), ack.begin(), ack.end());
    line.push_back(0x7E);
    const auto frames = decoded(decoder, line);
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].kind, FrameKind::ack);
    EXPECT_EQ(frames[0].seq, 2);
}

TEST(FrameDecoder, DropsAndCountsWhatIsNoFrame) {
    FrameDecoder decoder;
    Octets wrong = encoded({FrameKind::ack, 0, {}});
    wrong[3] ^= 1;
    EXPECT_TRUE(decoded(decoder, wrong).empty());
    EXPECT_EQ(decoder.counters().bad_fcs, 1U);
    EXPECT_TRUE(decoded(decoder, {0x7E, 0xFF, 0x7E}).empty());
    EXPECT_EQ(decoder.counters().too_short, 1U);
    Octets endless(500, 0x55);
    endless.push_back(0x7E);
    EXPECT_TRUE(decoded(decoder, endless).empty());
    EXPECT_EQ(decoder.counters().too_long, 1U);
    EXPECT_EQ(decoded(decoder, encoded({FrameKind::nack, 5, {}})).size(), 1U)
        << "the next frame is found";
}

TEST(FrameDecoder, AnyOctetsAreFramesOrCounted) {
    const std::uint64_t seed = 7;
    Random random(seed);
    FrameDecoder decoder;
    for (int i = 0; i < 2'000'000; ++i) {
        const bool mark = random.happens(50'000);
        const auto octet = mark ? std::uint8_t{0x7E} : static_cast<std::uint8_t>(random.below(256));
        if (const auto frame = decoder.on_octet(octet)) {
            ASSERT_LE(frame->data.size(), max_data) << "seed " << seed;
        }
    }
    EXPECT_GT(decoder.counters().bad_fcs, 1000U);
}

}  // namespace
}  // namespace romano::hdlc::frame_test
