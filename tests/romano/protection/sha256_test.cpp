// FIPS 180-4: NIST's examples, and every way to cut a text into parts.

#include "romano/protection/sha256.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/romano/protection/hex.h"

namespace romano::protection {
namespace {

std::string hash(Bytes text) {
    Sha256 made;
    made.add(text);
    return hex(made.finish());
}

TEST(Sha256, GivesTheStandardsExamples) {
    EXPECT_EQ(hash({}), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(hash(as_octets("abc")),
              "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(hash(as_octets("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq")),
              "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    EXPECT_EQ(hash(Octets(1'000'000, 'a')),
              "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, TakesATextInParts) {
    const Octets text = counting(150);
    for (std::size_t cut = 0; cut <= text.size(); ++cut) {
        Sha256 made;
        made.add(Bytes{text}.first(cut));
        made.add(Bytes{text}.subspan(cut));
        EXPECT_EQ(hex(made.finish()), hash(text)) << cut;
    }
}

}  // namespace
}  // namespace romano::protection
