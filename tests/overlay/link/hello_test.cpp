#include "overlay/link/hello.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace romano::link::hello_test {
namespace {

constexpr Hello hello{.from = {broker::BrokerId{0x0102030405060708}, 0x1112131415161718},
                      .to = {broker::BrokerId{0x2122232425262728}, 0x3132333435363738},
                      .nonce = {0x41, 0x42}};
constexpr Secret secret{1, 2, 3};

TEST(Hello, StandsInTheOctetsAsItsTableSays) {
    const auto octets = encode(hello, secret);
    EXPECT_EQ(as_text(Bytes{octets}.first(5)), "RLNK\x02");
    EXPECT_EQ(octets[5], 0x01);
    EXPECT_EQ(octets[13], 0x11);
    EXPECT_EQ(octets[21], 0x21);
    EXPECT_EQ(octets[36], 0x38);
    EXPECT_EQ(octets[37], 0x41);
}

TEST(Hello, SurvivesTheWire) {
    EXPECT_EQ(decode(encode(hello, secret), secret), hello);
}

TEST(Hello, AnyOtherSizeIsNone) {
    const auto octets = encode(hello, secret);
    for (std::size_t size = 0; size < octets.size(); ++size) {
        EXPECT_FALSE(decode(Bytes{octets}.first(size), secret)) << size;
    }
}

TEST(Hello, OneChangedBitAnywhereIsNone) {
    for (std::size_t bit = 0; bit < 8 * Hello::octets; ++bit) {
        auto octets = encode(hello, secret);
        octets[bit / 8] = static_cast<std::uint8_t>(octets[bit / 8] ^ (1U << bit % 8));
        EXPECT_FALSE(decode(octets, secret)) << bit;
    }
}

TEST(Hello, IsNoneWithoutTheSecret) {
    Secret other = secret;
    other.back() ^= 1U;
    EXPECT_FALSE(decode(encode(hello, other), secret));
    EXPECT_FALSE(decode(encode(hello, {}), secret));
}

// RFC 2104 with SHA-256, reckoned by Python's hmac.
TEST(Hello, ItsProofIsHmacSha256) {
    const auto octets = encode(hello, secret);
    constexpr std::array<std::uint8_t, 16> expected{0x68, 0x75, 0xd5, 0xd8, 0xc8, 0x20, 0x72, 0xb9,
                                                    0x7c, 0x48, 0x3b, 0x74, 0x2c, 0x9d, 0xab, 0x5d};
    EXPECT_TRUE(std::ranges::equal(Bytes{octets}.subspan(53), expected));
}

}  // namespace
}  // namespace romano::link::hello_test
