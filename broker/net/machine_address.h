// Addresses of this machine's interfaces, added and removed by rtnetlink (rtnetlink(7)), which
// libmnl speaks.
//
// An address that is added here is a lease: the kernel removes it by itself when it is not added
// again in time, so that a broker that is killed leaves none behind.
#pragma once

#include <boost/system/error_code.hpp>
#include <chrono>
#include <optional>

#include "romano/base/endpoint.h"

namespace romano::net {

enum class InterfaceIndex : unsigned {};

/// The interface that has an address in the same network, none of the loopback's.
[[nodiscard]] std::optional<InterfaceIndex> interface_towards(const Endpoint& address);

/// Whether this process may add addresses (CAP_NET_ADMIN).
[[nodiscard]] bool may_add_addresses();

/// Adds the address of `endpoint` alone (/32 or /128), or renews its lease.
[[nodiscard]] boost::system::error_code add_address(const Endpoint& endpoint,
                                                    InterfaceIndex interface,
                                                    std::chrono::seconds lease);
/// A broker added it by add_address(), and nobody else.
[[nodiscard]] bool is_leased(const Endpoint& endpoint);
[[nodiscard]] boost::system::error_code remove_address(const Endpoint& endpoint,
                                                       InterfaceIndex interface);

/// Lets ARP requests on the interface name its own address (arp_announce = 2, ip-sysctl). Linux
/// names the source of the datagram that waits for the answer, and whoever is asked takes that for
/// news: it would call clients of an address that went back to its own machine here again.
[[nodiscard]] boost::system::error_code ask_neighbours_as_itself(InterfaceIndex interface);

/// Lets the interface ask a neighbour that does not answer again after so long (retrans_time_ms of
/// ARP or neighbour discovery). Linux waits for a second: when a link is back, brokers would hear
/// each other's multicasts and not reach each other meanwhile.
[[nodiscard]] boost::system::error_code ask_neighbours_again_after(std::chrono::milliseconds time,
                                                                   Endpoint::Family family,
                                                                   InterfaceIndex interface);

}  // namespace romano::net
