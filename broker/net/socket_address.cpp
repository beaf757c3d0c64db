#include "broker/net/socket_address.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace romano::net {

SocketAddress to_socket_address(const Endpoint& endpoint) {
    SocketAddress out;
    if (endpoint.family == Endpoint::Family::ipv6) {
        out.v6.sin6_family = AF_INET6;
        out.v6.sin6_port = htons(endpoint.port);
        std::memcpy(&out.v6.sin6_addr, endpoint.address.data(), 16);
        out.v6.sin6_scope_id = endpoint.scope;
        out.size = sizeof(sockaddr_in6);
    } else {
        out.v4 = {};
        out.v4.sin_family = AF_INET;
        out.v4.sin_port = htons(endpoint.port);
        std::memcpy(&out.v4.sin_addr, endpoint.address.data(), 4);
        out.size = sizeof(sockaddr_in);
    }
    return out;
}

Endpoint to_endpoint(const SocketAddress& address) {
    switch (address.any.sa_family) {
        case AF_INET:
            return to_endpoint(address.v4.sin_addr, ntohs(address.v4.sin_port));
        case AF_INET6:
            return to_endpoint(address.v6.sin6_addr, ntohs(address.v6.sin6_port),
                               address.v6.sin6_scope_id);
        default:
            return {};
    }
}

Endpoint to_endpoint(const in_addr& address, std::uint16_t port) {
    Endpoint out;
    out.family = Endpoint::Family::ipv4;
    out.port = port;
    std::memcpy(out.address.data(), &address, 4);
    return out;
}

Endpoint to_endpoint(const in6_addr& address, std::uint16_t port, std::uint32_t interface) {
    Endpoint out;
    out.family = Endpoint::Family::ipv6;
    out.port = port;
    std::memcpy(out.address.data(), &address, 16);
    if (is_link_local(out) || is_link_group(out)) out.scope = interface;
    return out;
}

bool is_wildcard(const Endpoint& endpoint) {
    return std::ranges::all_of(endpoint.address, [](auto octet) { return octet == 0; });
}

bool is_loopback(const Endpoint& endpoint) {
    if (endpoint.family == Endpoint::Family::ipv4) return endpoint.address[0] == 127;
    std::array<std::uint8_t, 16> one{};
    one.back() = 1;
    return endpoint.family == Endpoint::Family::ipv6 && endpoint.address == one;
}

bool is_link_local(const Endpoint& endpoint) {
    return endpoint.family == Endpoint::Family::ipv6 && endpoint.address[0] == 0xFE &&
           (endpoint.address[1] & 0xC0U) == 0x80;
}

Endpoint as_reached_here(Endpoint address) {
    if (!is_wildcard(address)) return address;
    if (address.family == Endpoint::Family::ipv6) {
        address.address.back() = 1;
    } else {
        address.address = {127, 0, 0, 1};
    }
    return address;
}

bool is_multicast(const Endpoint& endpoint) {
    return endpoint.family == Endpoint::Family::ipv6 ? endpoint.address[0] == 0xFF
                                                     : (endpoint.address[0] & 0xF0U) == 0xE0;
}

bool is_link_group(const Endpoint& endpoint) {
    return endpoint.family == Endpoint::Family::ipv6 && endpoint.address[0] == 0xFF &&
           (endpoint.address[1] & 0x0FU) == 0x02;
}

}  // namespace romano::net
