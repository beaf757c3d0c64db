// The operating system's socket addresses to and from the cores' Endpoint.
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include "romano/base/endpoint.h"

namespace romano::net {

/// Room for an IPv4 or IPv6 socket address, and its size as system calls want it.
struct SocketAddress {
    union {
        sockaddr any;
        sockaddr_in v4;
        sockaddr_in6 v6;
    };
    socklen_t size = 0;

    SocketAddress() : v6{} {}
};

[[nodiscard]] SocketAddress to_socket_address(const Endpoint& endpoint);

/// Family none when the address is neither IPv4 nor IPv6.
[[nodiscard]] Endpoint to_endpoint(const SocketAddress& address);

[[nodiscard]] Endpoint to_endpoint(const in_addr& address, std::uint16_t port);
/// `interface` counts for link-local addresses only.
[[nodiscard]] Endpoint to_endpoint(const in6_addr& address, std::uint16_t port,
                                   std::uint32_t interface);

/// 0.0.0.0 or [::]: every address of the machine.
[[nodiscard]] bool is_wildcard(const Endpoint& endpoint);
/// 127.0.0.0/8 or [::1]: this machine alone reaches it.
[[nodiscard]] bool is_loopback(const Endpoint& endpoint);
/// fe80::/10: the same on every network, so that `scope` must say which.
[[nodiscard]] bool is_link_local(const Endpoint& endpoint);
/// Where this machine reaches what is served at `address`: loopback for a wildcard.
[[nodiscard]] Endpoint as_reached_here(Endpoint address);
[[nodiscard]] bool is_multicast(const Endpoint& endpoint);
/// ff02::...: an IPv6 group that each link has its own of.
[[nodiscard]] bool is_link_group(const Endpoint& endpoint);

}  // namespace romano::net
