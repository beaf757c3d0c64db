// Octets on the wire: views, and big-endian numbers read and written by position.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace romano {

using Bytes = std::span<const std::uint8_t>;
using MutableBytes = std::span<std::uint8_t>;

/// The 16-bit number at `at`; the caller has checked the size.
constexpr std::uint16_t be16(Bytes octets, std::size_t at) {
    return static_cast<std::uint16_t>((octets[at] << 8) | octets[at + 1]);
}

constexpr void put_be16(MutableBytes octets, std::size_t at, std::uint16_t value) {
    octets[at] = static_cast<std::uint8_t>(value >> 8);
    octets[at + 1] = static_cast<std::uint8_t>(value & 0xFF);
}

inline Bytes as_octets(std::string_view text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

inline std::string_view as_text(Bytes octets) {
    return {reinterpret_cast<const char*>(octets.data()), octets.size()};
}

}  // namespace romano
