// What the machine has of network interfaces: the address that serves peers, not clients; the links
// on which IPv6 discovery takes place.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "romano/base/endpoint.h"

namespace romano::net {

/// An address of `interface`, IPv4 before IPv6; without a name, of the first interface that is up,
/// no loopback and can multicast, else of the loopback. Port 0; family none when there is none.
[[nodiscard]] Endpoint interface_address(const std::string& interface);

/// Where a discovery group is to be joined, as interface numbers: the interface that has the
/// address `served`; for all addresses those that are up and can multicast, the loopback only when
/// it is alone.
[[nodiscard]] std::vector<std::uint32_t> links_of(const Endpoint& served);

}  // namespace romano::net
