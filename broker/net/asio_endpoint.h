// The cores' Endpoint to and from Boost.Asio's.
#pragma once

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/basic_endpoint.hpp>
#include <cstdint>

#include "romano/base/endpoint.h"

namespace romano::net {

/// `Protocol`: boost::asio::ip::udp or tcp.
template <typename Protocol>
[[nodiscard]] boost::asio::ip::basic_endpoint<Protocol> to_asio(const Endpoint& endpoint) {
    if (endpoint.family == Endpoint::Family::ipv6) {
        return {boost::asio::ip::address_v6(endpoint.address, endpoint.scope), endpoint.port};
    }
    boost::asio::ip::address_v4::bytes_type octets{};
    std::copy_n(endpoint.address.begin(), octets.size(), octets.begin());
    return {boost::asio::ip::address_v4(octets), endpoint.port};
}

template <typename Protocol>
[[nodiscard]] Endpoint to_endpoint(const boost::asio::ip::basic_endpoint<Protocol>& endpoint) {
    if (endpoint.address().is_v6()) {
        const boost::asio::ip::address_v6 address = endpoint.address().to_v6();
        return {.address = address.to_bytes(),
                .scope = static_cast<std::uint32_t>(address.scope_id()),
                .port = endpoint.port(),
                .family = Endpoint::Family::ipv6};
    }
    Endpoint out{.port = endpoint.port(), .family = Endpoint::Family::ipv4};
    std::ranges::copy(endpoint.address().to_v4().to_bytes(), out.address.begin());
    return out;
}

}  // namespace romano::net
