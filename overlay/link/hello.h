// What both ends of a link say first, and all that they ever say: who they are and whom they want.
//
//     0  4  "RLNK"
//     4  1  version, 1
//     5  8  sender: broker id       13  8  its incarnation
//    21  8  addressee: broker id    29  8  its incarnation
//
// Numbers are big-endian. The dialling side speaks first.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "broker/core/log_position.h"
#include "romano/base/bytes.h"

namespace romano::link {

struct Hello {
    static constexpr std::size_t octets = 37;

    broker::LogId from;
    broker::LogId to;

    friend bool operator==(const Hello&, const Hello&) = default;
};

[[nodiscard]] std::array<std::uint8_t, Hello::octets> encode(const Hello& hello);
/// Empty when the octets are no hello of this version.
[[nodiscard]] std::optional<Hello> decode(Bytes octets);

}  // namespace romano::link
