#include "experiments/robots/stamp.h"

#include <gtest/gtest.h>

#include <array>

namespace romano::experiments::stamp_test {
namespace {

TEST(Stamp, ReadsBackFromTheFrontOfAPayload) {
    std::array<std::uint8_t, 32> payload{};
    const Stamp stamp{.publisher = 0x01020304,
                      .sequence = 0xFFFFFFFE,
                      .sent_at = Instant{Duration{0x0102030405060708}}};
    write_stamp(stamp, payload);
    EXPECT_EQ(payload[0], 1);
    EXPECT_EQ(payload[15], 8);
    EXPECT_EQ(payload[16], 0);
    EXPECT_EQ(read_stamp(payload), stamp);
}

TEST(Stamp, IsNoneInAShortPayload) {
    const std::array<std::uint8_t, 15> payload{};
    EXPECT_FALSE(read_stamp(payload));
}

}  // namespace
}  // namespace romano::experiments::stamp_test
