// FIPS 197 and NIST SP 800-38A, the ECB examples.

#include "romano/protection/aes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/romano/protection/hex.h"

namespace romano::protection {
namespace {

std::string encrypted(std::string_view key, std::string_view block) {
    Key as_key;
    Block as_block;
    std::ranges::copy(octets(key), as_key.begin());
    std::ranges::copy(octets(block), as_block.begin());
    encrypt(as_key, as_block);
    return hex(as_block);
}

TEST(Aes128, GivesTheExamplesOfFips197) {
    EXPECT_EQ(encrypted("2b7e151628aed2a6abf7158809cf4f3c", "3243f6a8885a308d313198a2e0370734"),
              "3925841d02dc09fbdc118597196a0b32");
    EXPECT_EQ(encrypted("000102030405060708090a0b0c0d0e0f", "00112233445566778899aabbccddeeff"),
              "69c4e0d86a7b0430d8cdb78070b4c55a");
}

TEST(Aes128, GivesTheExamplesOfNistSp80038a) {
    const std::string key = "2b7e151628aed2a6abf7158809cf4f3c";
    EXPECT_EQ(encrypted(key, "6bc1bee22e409f96e93d7e117393172a"),
              "3ad77bb40d7a3660a89ecaf32466ef97");
    EXPECT_EQ(encrypted(key, "ae2d8a571e03ac9c9eb76fac45af8e51"),
              "f5d3d58503b9699de785895a96fdbaaf");
    EXPECT_EQ(encrypted(key, "30c81c46a35ce411e5fbc1191a0a52ef"),
              "43b1cd7f598ece23881b00e3ed030688");
    EXPECT_EQ(encrypted(key, "f69f2445df4f9b17ad2b417be66c3710"),
              "7b0c785e27e8ad3f8223207104725dd4");
}

}  // namespace
}  // namespace romano::protection
