// AES-CCM: the packet vectors of RFC 3610 section 8 and the examples of NIST SP 800-38C appendix C
// (its fourth has more readable octets than are supported).

#include "romano/protection/ccm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/romano/protection/hex.h"

namespace romano::protection {
namespace {

struct Vector {
    Key key;
    Octets nonce;
    Octets readable;
    Octets message;
    std::size_t tag_size;
    std::string sealed;  // message and tag
};

std::string seal(const Vector& vector) {
    Octets message = vector.message;
    Octets tag(vector.tag_size);
    Ccm{vector.key, vector.nonce}.seal(vector.readable, message, tag);
    return hex(message) + hex(tag);
}

std::string open(const Vector& vector) {
    Octets message = octets(vector.sealed);
    const Octets tag(message.end() - static_cast<std::ptrdiff_t>(vector.tag_size), message.end());
    message.resize(message.size() - vector.tag_size);
    return Ccm(vector.key, vector.nonce).open(vector.readable, message, tag) ? hex(message)
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

TEST(AesCcm, SealsAndOpensThePacketsOfRfc3610) {
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
        EXPECT_EQ(seal(vector), vector.sealed);
        EXPECT_EQ(open(vector), hex(vector.message));
    }
}

TEST(AesCcm, SealsAndOpensTheExamplesOfNistSp80038c) {
    for (const Vector& vector :
         {sp_800_38c(7, 8, 4, 4, "7162015b4dac255d"),
          sp_800_38c(8, 16, 16, 6, "d2a1f0e051ea5f62081a7792073d593d1fc64fbfaccd"),
          sp_800_38c(12, 20, 24, 8,
                     "e3b201a9f5b71a7a9b1ceaeccd97e70b6176aad9a4428aa5484392fbc1b09951")}) {
        EXPECT_EQ(seal(vector), vector.sealed);
        EXPECT_EQ(open(vector), hex(vector.message));
    }
}

TEST(AesCcm, LeavesNothingOfAMessageWhoseTagIsWrong) {
    Octets message(20, 0x55);
    const Key key = counting_array<16>();
    EXPECT_FALSE(Ccm(key, counting(13)).open(counting(20), message, Octets(8)));
    EXPECT_EQ(message, Octets(20));
}

}  // namespace
}  // namespace romano::protection
