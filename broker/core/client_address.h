// Where a client is: the UDP endpoint that its datagrams come from and, behind a forwarder
// (MQTT-SN 1.2 section 5.5), its wireless node id. Two clients may have the same: a NAT that keeps
// source ports tells them apart by the service address that they talk to, and so does a broker.
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

/// Of a client whose place another one has (G7): its host, and no port, so that nobody speaks
/// there. A session says so wherever it goes.
[[nodiscard]] inline ClientAddress without_place(const ClientAddress& address) {
    ClientAddress host{address.endpoint, {}};
    host.endpoint.port = 0;
    return host;
}
[[nodiscard]] inline bool has_place(const ClientAddress& address) {
    return address.endpoint.family != Endpoint::Family::none &&
           (address.endpoint.port != 0 || address.endpoint == owner_endpoint);
}

struct ClientAddressHash {
    std::size_t operator()(const ClientAddress& address) const {
        std::size_t h = address.endpoint.hash();
        if (!address.wireless_node_id.empty()) {
            h ^= std::hash<std::string>{}(address.wireless_node_id) * 0x9E3779B97F4A7C15ULL;
        }
        return h;
    }
};

/// Where a datagram came from and which service address it was sent to. Who was heard there last
/// is who speaks there.
struct Origin {
    Endpoint via;
    ClientAddress from;

    friend bool operator==(const Origin&, const Origin&) = default;
};

/// Whose message reaches the core from there has proved who it is, unless that is open to all, as
/// SEARCHGW is.
[[nodiscard]] inline bool has_key(const Origin& origin) {
    return origin.via.packets != Endpoint::Packets::plain;
}

struct OriginHash {
    std::size_t operator()(const Origin& origin) const {
        return ClientAddressHash{}(origin.from) ^ (origin.via.hash() * 0x9E3779B97F4A7C15ULL);
    }
};

}  // namespace romano::broker
