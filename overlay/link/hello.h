// What both ends of a link say first, and all that they ever say: who they are, whom they want, and
// that they may.
//
//     0  4  "RLNK"
//     4  1  version, 2
//     5  8  sender: broker id       13  8  its incarnation
//    21  8  addressee: broker id    29  8  its incarnation
//    37 16  nonce: of the side that dials, at random; the answer has the same
//    53 16  proof: of all before it, HMAC-SHA-256 under the dialled process's secret, cut
//
// Numbers are big-endian. The dialling side speaks first. A process tells its secret to its peers
// in its particulars, which brokers with papers seal: then whoever knows it is a broker of the
// fleet.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "broker/core/log_position.h"
#include "romano/base/bytes.h"

namespace romano::link {

/// What a process proves itself with to those who dial it, and they to it.
using Secret = std::array<std::uint8_t, 16>;
using Nonce = std::array<std::uint8_t, 16>;

struct Hello {
    static constexpr std::size_t octets = 69;

    broker::LogId from;
    broker::LogId to;
    Nonce nonce;

    friend bool operator==(const Hello&, const Hello&) = default;
};

[[nodiscard]] std::array<std::uint8_t, Hello::octets> encode(const Hello& hello,
                                                             const Secret& secret);
/// Empty when the octets are no hello of this version, or do not prove that their sender knows the
/// secret.
[[nodiscard]] std::optional<Hello> decode(Bytes octets, const Secret& secret);

/// From the system's source of random numbers, good for secrets.
[[nodiscard]] std::array<std::uint8_t, 16> sixteen_random_octets();

}  // namespace romano::link
