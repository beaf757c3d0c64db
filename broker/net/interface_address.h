// The address of a network interface of this machine, for sockets that serve peers, not clients.
#pragma once

#include <string>

#include "romano/base/endpoint.h"

namespace romano::net {

/// An address of `interface`, IPv4 before IPv6; without a name, of the first interface that is up,
/// no loopback and can multicast, else of the loopback. Port 0; family none when there is none.
[[nodiscard]] Endpoint interface_address(const std::string& interface);

}  // namespace romano::net
