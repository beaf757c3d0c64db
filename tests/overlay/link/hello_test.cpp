#include "overlay/link/hello.h"

#include <gtest/gtest.h>

#include <string>

namespace romano::link::hello_test {
namespace {

constexpr Hello hello{.from = {broker::BrokerId{0x0102030405060708}, 0x1112131415161718},
                      .to = {broker::BrokerId{0x2122232425262728}, 0x3132333435363738}};

TEST(Hello, StandsInTheOctetsAsItsTableSays) {
    const auto octets = encode(hello);
    EXPECT_EQ(as_text(Bytes{octets}.first(5)), "RLNK\x01");
    EXPECT_EQ(octets[5], 0x01);
    EXPECT_EQ(octets[13], 0x11);
    EXPECT_EQ(octets[21], 0x21);
    EXPECT_EQ(octets[36], 0x38);
}

TEST(Hello, SurvivesTheWire) {
    EXPECT_EQ(decode(encode(hello)), hello);
}

TEST(Hello, AnyOtherSizeIsNone) {
    const auto octets = encode(hello);
    for (std::size_t size = 0; size < octets.size(); ++size) {
        EXPECT_FALSE(decode(Bytes{octets}.first(size))) << size;
    }
}

TEST(Hello, AnyOtherOpeningIsNone) {
    for (std::size_t at = 0; at < 5; ++at) {
        auto octets = encode(hello);
        octets[at] ^= 0x01;
        EXPECT_FALSE(decode(octets)) << at;
    }
}

}  // namespace
}  // namespace romano::link::hello_test
