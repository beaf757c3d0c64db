// HKDF by RFC 5869 appendix A, and what is derived by it.

#include "romano/protection/keys.h"

#include <gtest/gtest.h>

#include "tests/romano/protection/hex.h"

namespace romano::protection {
namespace {

TEST(Hkdf, GivesTheExamplesOfRfc5869) {
    const Octets secret(22, 0x0B);
    const Octets info = octets("f0f1f2f3f4f5f6f7f8f9");
    Octets out(42);
    hkdf_sha256(secret, counting(13), {}, info, out);  // A.1
    EXPECT_EQ(
        hex(out),
        "3cb25f25faacd57a90434f64d0362f2a2d2d0a90cf1a5a4c5db02d56ecc4c5bf34007208d5b887185865");
    hkdf_sha256(secret, {}, {}, {}, out);  // A.3
    EXPECT_EQ(
        hex(out),
        "8da4e775a563c18f715f802a063c5a31b8a11f5c5ee1879ec3454e5f3c738d2d9d201395faa4b61a96c8");
}

TEST(Keys, EachDirectionHasItsOwn) {  // the octets are of another implementation of HKDF
    const auto keys = direction_keys({counting_array<16>()});
    EXPECT_EQ(hex(keys.to_broker), "f6545605e9cf93aacd07cb9cb95fcafc");
    EXPECT_EQ(hex(keys.to_robot), "6b39e7b681eb10aaf772ce8667d976d6");
}

TEST(Keys, EachSessionOfAPersonHasItsOwn) {
    const OperatorKey anna{counting_array<16>(0x80)};
    EXPECT_EQ(hex(session_key(anna, "anna").octets), "a9dffa807788c5e4875d682a2fb78d32");
    EXPECT_EQ(hex(session_key(anna, "anna/1").octets), "2b88b5396c6be520751857a4f523ed8e");
}

}  // namespace
}  // namespace romano::protection
