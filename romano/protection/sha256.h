// SHA-256 (FIPS 180-4) for texts of less than 512 MB, small instead of fast.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "romano/base/bytes.h"

namespace romano::protection {

class Sha256 {
public:
    using Digest = std::array<std::uint8_t, 32>;
    static constexpr std::size_t block_size = 64;

    void add(Bytes octets);
    /// Once, at the end.
    [[nodiscard]] Digest finish();

private:
    void add(std::uint8_t octet);
    void compress();

    std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                        0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    std::array<std::uint32_t, 16> block_{};  // of the schedule's 64 words the last sixteen
    std::uint32_t size_ = 0;                 // octets so far
};

}  // namespace romano::protection
