// Tells all neighbours at once that an address is here now: gratuitous ARP (RFC 5227 section 3) for
// IPv4, an unsolicited neighbour advertisement (RFC 4861 section 7.2.6) for IPv6.
#pragma once

#include <boost/system/error_code.hpp>

#include "broker/net/machine_address.h"
#include "romano/base/endpoint.h"

namespace romano::net {

class NeighbourAnnouncer {
public:
    NeighbourAnnouncer() = default;
    ~NeighbourAnnouncer();
    NeighbourAnnouncer(const NeighbourAnnouncer&) = delete;
    NeighbourAnnouncer& operator=(const NeighbourAnnouncer&) = delete;

    /// Needs CAP_NET_RAW.
    [[nodiscard]] boost::system::error_code announce(const Endpoint& endpoint,
                                                     InterfaceIndex interface);

private:
    [[nodiscard]] boost::system::error_code announce_ipv4(const Endpoint& endpoint,
                                                          InterfaceIndex interface);

    /// Stays open: to close a packet socket takes the kernel 10 to 20 ms, and peers do not wait
    /// much longer for a beacon.
    int packet_socket_ = -1;
};

}  // namespace romano::net
