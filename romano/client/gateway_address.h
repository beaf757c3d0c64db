// The gwAdd field of GWINFO: MQTT-SN 1.2 section 5.3.5, which leaves its form open.
//
// Read: an IPv4 or IPv6 address with or without a port, also behind a length octet. Written:
// address and port.
#pragma once

#include <cstdint>
#include <optional>

#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/base/fixed_vector.h"

namespace romano::client {

using GatewayAddressOctets = FixedVector<std::uint8_t, 18>;

/// `port` is for a form without one. Nothing when the size fits none of the forms.
[[nodiscard]] std::optional<Endpoint> read_gateway_address(Bytes octets, std::uint16_t port);

[[nodiscard]] GatewayAddressOctets write_gateway_address(const Endpoint& gateway);

}  // namespace romano::client
