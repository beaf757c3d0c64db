#include "romano/client/gateway_address.h"

#include <algorithm>
#include <array>

namespace romano::client {

std::optional<Endpoint> read_gateway_address(Bytes octets, std::uint16_t port) {
    if (octets.size() % 2 == 1) octets = octets.subspan(1);  // a length octet in front
    const bool is_ipv4 = octets.size() < 16;
    const std::size_t address_size = is_ipv4 ? 4 : 16;
    const bool has_port = octets.size() == address_size + 2;
    if (!has_port && octets.size() != address_size) return std::nullopt;
    Endpoint gateway;
    gateway.family = is_ipv4 ? Endpoint::Family::ipv4 : Endpoint::Family::ipv6;
    gateway.port = has_port ? be16(octets, address_size) : port;
    std::copy_n(octets.begin(), address_size, gateway.address.begin());
    return gateway;
}

GatewayAddressOctets write_gateway_address(const Endpoint& gateway) {
    const std::size_t address_size = gateway.family == Endpoint::Family::ipv6 ? 16 : 4;
    std::array<std::uint8_t, 18> octets{};
    std::copy_n(gateway.address.begin(), address_size, octets.begin());
    put_be16(octets, address_size, gateway.port);
    GatewayAddressOctets written;
    (void)written.assign(Bytes{octets}.first(address_size + 2));  // 18 at most: it fits
    return written;
}

}  // namespace romano::client
