#include "romano/client/gateway_address.h"

#include <algorithm>
#include <array>

namespace romano::client {

std::optional<Endpoint> read_gateway_address(Bytes octets, std::uint16_t port) {
    if (octets.size() % 2 == 1) octets = octets.subspan(1);  // a length octet in front
    Endpoint gateway;
    gateway.port = port;
    std::size_t address_size = 0;
    if (octets.size() == 4 || octets.size() == 6) {
        gateway.family = Endpoint::Family::ipv4;
        address_size = 4;
    } else if (octets.size() == 16 || octets.size() == 18) {
        gateway.family = Endpoint::Family::ipv6;
        address_size = 16;
    } else {
        return std::nullopt;
    }
    std::copy_n(octets.begin(), address_size, gateway.address.begin());
    if (octets.size() > address_size) gateway.port = be16(octets, address_size);
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
