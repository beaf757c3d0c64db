// Octets as published vectors write them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "romano/base/bytes.h"

namespace romano::protection {

using Octets = std::vector<std::uint8_t>;

inline Octets octets(std::string_view hex) {
    Octets read;
    for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
        read.push_back(
            static_cast<std::uint8_t>(std::stoul(std::string{hex.substr(i, 2)}, nullptr, 16)));
    }
    return read;
}

inline std::string hex(Bytes octets) {
    std::string text;
    for (const std::uint8_t octet : octets) {
        text += "0123456789abcdef"[octet >> 4U];
        text += "0123456789abcdef"[octet & 15U];
    }
    return text;
}

/// `size` octets that count up.
inline Octets counting(std::size_t size, std::uint8_t first = 0) {
    Octets made(size);
    for (std::size_t i = 0; i < size; ++i) made[i] = static_cast<std::uint8_t>(first + i);
    return made;
}

template <std::size_t Size>
std::array<std::uint8_t, Size> counting_array(std::uint8_t first = 0) {
    std::array<std::uint8_t, Size> made;
    for (std::size_t i = 0; i < Size; ++i) made[i] = static_cast<std::uint8_t>(first + i);
    return made;
}

}  // namespace romano::protection
