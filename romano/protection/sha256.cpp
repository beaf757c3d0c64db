#include "romano/protection/sha256.h"

#include <bit>

namespace romano::protection {
namespace {

constexpr std::uint32_t constants[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

}  // namespace

void Sha256::add(Bytes octets) {
    for (const std::uint8_t octet : octets) add(octet);
}

void Sha256::add(std::uint8_t octet) {
    std::uint32_t& word = block_[size_ / 4 % block_.size()];
    word = word << 8U | octet;
    ++size_;
    if (size_ % block_size == 0) compress();
}

Sha256::Digest Sha256::finish() {
    const std::uint32_t bits = 8 * size_;
    add(std::uint8_t{0x80});
    while (size_ % block_size != block_size - 8) add(std::uint8_t{0});
    for (unsigned i = 0; i < 4; ++i) add(std::uint8_t{0});
    for (unsigned shift = 32; shift != 0;) {
        shift -= 8;
        add(static_cast<std::uint8_t>(bits >> shift));
    }
    Digest digest;
    for (std::size_t i = 0; i < digest.size(); ++i) {
        digest[i] = static_cast<std::uint8_t>(state_[i / 4] >> (24 - 8 * (i % 4)));
    }
    return digest;
}

void Sha256::compress() {
    auto a = state_;
    for (std::size_t i = 0; i < 64; ++i) {
        std::uint32_t& word = block_[i % 16];
        if (i >= 16) {
            const std::uint32_t w2 = block_[(i - 2) % 16];
            const std::uint32_t w15 = block_[(i - 15) % 16];
            word += (std::rotr(w2, 17) ^ std::rotr(w2, 19) ^ (w2 >> 10U)) + block_[(i - 7) % 16] +
                    (std::rotr(w15, 7) ^ std::rotr(w15, 18) ^ (w15 >> 3U));
        }
        const std::uint32_t t1 = a[7] +
                                 (std::rotr(a[4], 6) ^ std::rotr(a[4], 11) ^ std::rotr(a[4], 25)) +
                                 ((a[4] & a[5]) ^ (~a[4] & a[6])) + constants[i] + word;
        const std::uint32_t t2 = (std::rotr(a[0], 2) ^ std::rotr(a[0], 13) ^ std::rotr(a[0], 22)) +
                                 ((a[0] & a[1]) ^ (a[0] & a[2]) ^ (a[1] & a[2]));
        for (std::size_t k = 7; k > 0; --k) a[k] = a[k - 1];
        a[4] += t1;
        a[0] = t1 + t2;
    }
    for (std::size_t i = 0; i < 8; ++i) state_[i] += a[i];
}

}  // namespace romano::protection
