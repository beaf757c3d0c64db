// An IP address and UDP port as plain octets, without any operating system's socket types.
//
// IPv4 addresses are held in the first four octets. `scope` is the interface index of a
// link-local IPv6 address, 0 otherwise. How clients speak at a service address is part of it, so
// that it is known wherever the address moves.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>

#include "romano/base/fnv1a.h"

namespace romano {

struct Endpoint {
    enum class Family : std::uint8_t { none, ipv4, ipv6 };
    /// sealed: romano/protection; dtls: broker/dtls.
    enum class Packets : std::uint8_t { plain, sealed, dtls };

    std::array<std::uint8_t, 16> address{};
    std::uint32_t scope = 0;
    std::uint16_t port = 0;
    Family family = Family::none;
    Packets packets = Packets::plain;  // of a service address

    friend bool operator==(const Endpoint&, const Endpoint&) = default;
    friend auto operator<=>(const Endpoint&, const Endpoint&) = default;

    /// Of all fields: stable between runs and machines.
    [[nodiscard]] constexpr std::size_t hash() const {
        Fnv1a<std::uint64_t> sum;
        const std::size_t used = family == Family::ipv6 ? 16 : 4;
        for (std::size_t i = 0; i < used; ++i) sum.add(address[i]);
        sum.add(port);
        sum.add(scope);
        if (packets != Packets::plain) sum.add(static_cast<std::uint8_t>(packets));
        return static_cast<std::size_t>(sum.value() ^ (sum.value() >> 32U));
    }
};

struct EndpointHash {
    std::size_t operator()(const Endpoint& endpoint) const { return endpoint.hash(); }
};

}  // namespace romano
