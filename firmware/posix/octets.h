// Numbers of a ROMANO value: i32, big-endian.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace romano::firmware {

inline void put_be32(std::uint8_t* out, double value) {
    const auto octets = static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(value)));
    for (unsigned i = 0; i < 4; ++i) {
        out[i] = static_cast<std::uint8_t>(octets >> (24U - 8U * i));
    }
}

inline double be32(std::span<const std::uint8_t> octets, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8U | octets[at + i];
    return static_cast<std::int32_t>(value);
}

}  // namespace romano::firmware
