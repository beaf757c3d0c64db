// AES-CCM, of chips and of computers: the packet vectors of RFC 3610 section 8 and the examples of
// NIST SP 800-38C appendix C (its fourth has more readable octets than are supported).

#include "romano/protection/ccm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "romano/protection/libcrypto/scheduled_ccm.h"
#include "tests/romano/protection/hex.h"

namespace romano::protection {
namespace {

struct OfChips {
    static void seal(const Key& key, Bytes nonce, Bytes readable, MutableBytes message,
                     MutableBytes tag) {
        Ccm{key, nonce}.seal(readable, message, tag);
    }
    static bool open(const Key& key, Bytes nonce, Bytes readable, MutableBytes message, Bytes tag) {
        return Ccm{key, nonce}.open(readable, message, tag);
    }
};

struct OfComputers {
    static void seal(const Key& key, Bytes nonce, Bytes readable, MutableBytes message,
                     MutableBytes tag) {
        ScheduledCcm::of(key).seal(nonce, readable, message, tag);
    }
    static bool open(const Key& key, Bytes nonce, Bytes readable, MutableBytes message, Bytes tag) {
        return ScheduledCcm::of(key).open(nonce, readable, message, tag);
    }
};

struct Vector {
    Key key;
    Octets nonce;
    Octets readable;
    Octets message;
    std::size_t tag_size;
    std::string sealed;  // message and tag
};

template <typename Cipher>
std::string seal(const Vector& vector) {
    Octets message = vector.message;
    Octets tag(vector.tag_size);
    Cipher::seal(vector.key, vector.nonce, vector.readable, message, tag);
    return hex(message) + hex(tag);
}

template <typename Cipher>
std::string open(const Vector& vector) {
    Octets message = octets(vector.sealed);
    const Octets tag(message.end() - static_cast<std::ptrdiff_t>(vector.tag_size), message.end());
    message.resize(message.size() - vector.tag_size);
    return Cipher::open(vector.key, vector.nonce, vector.readable, message, tag) ? hex(message)
                                                                                 : "refused";
}

/// The RFC's octets count up from the readable ones through the message.
Vector rfc_3610(const char* nonce, std::size_t readable, std::size_t all, std::size_t tag_size,
                const char* sealed) {
    return {.key = counting_array<16>(0xC0),
            .nonce = octets(std::string{nonce} + "a0a1a2a3a4a5"),
            .readable = counting(readable),
            .message = counting(all - readable, static_cast<std::uint8_t>(readable)),
            .tag_size = tag_size,
            .sealed = sealed};
}

Vector sp_800_38c(std::size_t nonce, std::size_t readable, std::size_t message,
                  std::size_t tag_size, const char* sealed) {
    return {.key = counting_array<16>(0x40),
            .nonce = counting(nonce, 0x10),
            .readable = counting(readable),
            .message = counting(message, 0x20),
            .tag_size = tag_size,
            .sealed = sealed};
}

template <typename Cipher>
class AesCcm : public testing::Test {};
using Ciphers = testing::Types<OfChips, OfComputers>;
TYPED_TEST_SUITE(AesCcm, Ciphers);

TYPED_TEST(AesCcm, SealsAndOpensThePacketsOfRfc3610) {
    for (const Vector& vector :
         {rfc_3610("00000003020100", 8, 31, 8,
                   "588c979a61c663d2f066d0c2c0f989806d5f6b61dac38417e8d12cfdf926e0"),
          rfc_3610("00000004030201", 8, 32, 8,
                   "72c91a36e135f8cf291ca894085c87e3cc15c439c9e43a3ba091d56e10400916"),
          rfc_3610("00000005040302", 8, 33, 8,
                   "51b1e5f44a197d1da46b0f8e2d282ae871e838bb64da8596574adaa76fbd9fb0c5"),
          rfc_3610("00000006050403", 12, 31, 8,
                   "a28c6865939a9a79faaa5c4c2a9d4a91cdac8c96c861b9c9e61ef1"),
          rfc_3610("00000007060504", 12, 32, 8,
                   "dcf1fb7b5d9e23fb9d4e131253658ad86ebdca3e51e83f077d9c2d93"),
          rfc_3610("00000008070605", 12, 33, 8,
                   "6fc1b011f006568b5171a42d953d469b2570a4bd87405a0443ac91cb94"),
          rfc_3610("00000009080706", 8, 31, 10,
                   "0135d1b2c95f41d5d1d4fec185d166b8094e999dfed96c048c56602c97acbb7490")}) {
        EXPECT_EQ(seal<TypeParam>(vector), vector.sealed);
        EXPECT_EQ(open<TypeParam>(vector), hex(vector.message));
    }
}

TYPED_TEST(AesCcm, SealsAndOpensTheExamplesOfNistSp80038c) {
    for (const Vector& vector :
         {sp_800_38c(7, 8, 4, 4, "7162015b4dac255d"),
          sp_800_38c(8, 16, 16, 6, "d2a1f0e051ea5f62081a7792073d593d1fc64fbfaccd"),
          sp_800_38c(12, 20, 24, 8,
                     "e3b201a9f5b71a7a9b1ceaeccd97e70b6176aad9a4428aa5484392fbc1b09951")}) {
        EXPECT_EQ(seal<TypeParam>(vector), vector.sealed);
        EXPECT_EQ(open<TypeParam>(vector), hex(vector.message));
    }
}

TYPED_TEST(AesCcm, LeavesNothingOfAMessageWhoseTagIsWrong) {
    Octets message(20, 0x55);
    const Key key = counting_array<16>();
    EXPECT_FALSE(TypeParam::open(key, counting(13), counting(20), message, Octets(8)));
    EXPECT_EQ(message, Octets(20));
}

TYPED_TEST(AesCcm, RefusesAMessageOfWhichAnyBitIsAnother) {
    const Key key = counting_array<16>();
    Octets sealed = counting(20);
    Octets tag(8);
    TypeParam::seal(key, counting(13), counting(20), sealed, tag);
    for (std::size_t bit = 0; bit < 8 * (sealed.size() + tag.size()); ++bit) {
        Octets message = sealed;
        Octets its_tag = tag;
        const std::size_t at = bit / 8;
        auto& octet = at < sealed.size() ? message[at] : its_tag[at - sealed.size()];
        octet = static_cast<std::uint8_t>(octet ^ 1U << bit % 8);
        EXPECT_FALSE(TypeParam::open(key, counting(13), counting(20), message, its_tag)) << bit;
    }
}

/// A scheduled key has a past: what it did last, and whose place it took.
TEST(AesCcmOfComputers, MakesTheOctetsOfChipsForEveryKeyAndSizeInWhateverOrder) {
    for (std::size_t size = 1; size < 1'000; size += size < 70 ? 1 : 61) {
        for (std::uint8_t last = 1; last <= 3; ++last) {
            Key key = counting_array<16>(size % 2 == 0 ? 7 : 8);
            key.back() = last;  // these share a place
            const std::size_t readable = 1 + size % 50;
            Octets expected = counting(size);
            Octets expected_tag(8);
            OfChips::seal(key, counting(12), counting(readable), expected, expected_tag);
            Octets message = counting(size);
            Octets tag(8);
            OfComputers::seal(key, counting(12), counting(readable), message, tag);
            EXPECT_EQ(hex(message) + hex(tag), hex(expected) + hex(expected_tag)) << size;
            EXPECT_TRUE(
                OfComputers::open(key, counting(12), counting(readable), message, expected_tag));
            EXPECT_EQ(message, counting(size));
        }
    }
}

}  // namespace
}  // namespace romano::protection
