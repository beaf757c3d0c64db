#include "romano/protection/aes.h"

#include <cstddef>

namespace romano::protection {
namespace {

/// An octet times x in GF(2^8), FIPS 197 section 4.2.1.
constexpr std::uint8_t doubled(unsigned value) {
    return static_cast<std::uint8_t>((value << 1U) ^ ((value >> 7U) * 0x1BU));
}

/// FIPS 197 section 5.1.1, from its definition: the inverse, then an affine map. All numbers but 0
/// are powers of 3, so 3^n and its inverse 3^-n are walked through together.
constexpr std::array<std::uint8_t, 256> make_s_box() {
    std::array<std::uint8_t, 256> box{};
    std::uint8_t number = 1;
    std::uint8_t inverse = 1;
    do {
        number = static_cast<std::uint8_t>(number ^ doubled(number));
        inverse = static_cast<std::uint8_t>(inverse ^ (inverse << 1U));  // divided by 3
        inverse = static_cast<std::uint8_t>(inverse ^ (inverse << 2U));
        inverse = static_cast<std::uint8_t>(inverse ^ (inverse << 4U));
        if ((inverse & 0x80U) != 0) inverse ^= 0x09;
        unsigned mapped = 0x63;
        for (unsigned turn = 0; turn < 5; ++turn) {
            mapped ^= (unsigned{inverse} << turn | unsigned{inverse} >> (8 - turn)) & 0xFFU;
        }
        box[number] = static_cast<std::uint8_t>(mapped);
    } while (number != 1);
    box[0] = 0x63;
    return box;
}

constexpr std::array<std::uint8_t, 256> s_box = make_s_box();

void add(const Key& round_key, Block& block) {
    for (std::size_t i = 0; i < block.size(); ++i) block[i] ^= round_key[i];
}

/// SubBytes and ShiftRows, and MixColumns but in the last round.
void mix(Block& block, unsigned round) {
    Block shifted;
    for (std::size_t i = 0; i < block.size(); ++i) shifted[i] = s_box[block[i * 5 % 16]];
    for (std::size_t i = 0; i < block.size(); ++i) {
        std::uint8_t mixed = shifted[i];
        if (round != 10) {
            const std::uint8_t* column = shifted.data() + i / 4 * 4;
            mixed ^= column[0] ^ column[1] ^ column[2] ^ column[3];
            mixed ^= doubled(shifted[i] ^ column[(i + 1) % 4]);
        }
        block[i] = mixed;
    }
}

void make_next(Key& round_key, std::uint8_t constant) {
    for (std::size_t i = 0; i < 4; ++i) round_key[i] ^= s_box[round_key[12 + (i + 1) % 4]];
    round_key[0] ^= constant;
    for (std::size_t i = 4; i < round_key.size(); ++i) round_key[i] ^= round_key[i - 4];
}

}  // namespace

void encrypt(const Key& key, Block& block) {
    Key round_key = key;
    std::uint8_t constant = 1;
    for (unsigned round = 1;; ++round) {
        add(round_key, block);
        if (round > 10) return;
        mix(block, round);
        make_next(round_key, constant);
        constant = doubled(constant);
    }
}

}  // namespace romano::protection
