// The Connection IDs (RFC 9146) that brokers give to clients: a place among the fleet's brokers,
// which is one broker's for good, and seven octets at random. So two brokers never give the same,
// and any of them finds the association of a record that an other broker's client sends.
#pragma once

#include <cstddef>
#include <cstdint>

#include "broker/dtls/association.h"
#include "romano/base/bytes.h"

namespace romano::dtls {

inline constexpr std::size_t own_id_octets = 8;

[[nodiscard]] constexpr AssociationId own_id(std::uint32_t place, std::uint64_t random) {
    return AssociationId{std::uint64_t{place} << 56U | (random & ((std::uint64_t{1} << 56U) - 1))};
}

/// As it stands in a record.
[[nodiscard]] inline AssociationId own_id_of(Bytes octets) {
    std::uint64_t id = 0;
    for (const std::uint8_t octet : octets) id = id << 8U | octet;
    return AssociationId{id};
}

}  // namespace romano::dtls
