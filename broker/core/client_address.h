// Where a client is: the UDP endpoint that its datagrams come from and, behind a forwarder
// (MQTT-SN 1.2 section 5.5), its wireless node id.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "romano/base/endpoint.h"

namespace romano::broker {

struct ClientAddress {
    Endpoint endpoint;             // the client's, or its forwarder's
    std::string wireless_node_id;  // opaque octets; empty when there is no forwarder

    friend bool operator==(const ClientAddress&, const ClientAddress&) = default;
};

/// Where the session that the broker's owner reads is said to be: no datagram comes from there.
inline constexpr Endpoint owner_endpoint{.address = {}, .family = Endpoint::Family::ipv4};

struct ClientAddressHash {
    std::size_t operator()(const ClientAddress& address) const {
        std::size_t h = address.endpoint.hash();
        if (!address.wireless_node_id.empty()) {
            h ^= std::hash<std::string>{}(address.wireless_node_id) * 0x9E3779B97F4A7C15ULL;
        }
        return h;
    }
};

}  // namespace romano::broker
