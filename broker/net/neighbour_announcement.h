// Tells all neighbours at once that an address is here now: gratuitous ARP (RFC 5227 section 3) for
// IPv4, an unsolicited neighbour advertisement (RFC 4861 section 7.2.6) for IPv6.
#pragma once

#include <boost/system/error_code.hpp>

#include "broker/net/machine_address.h"
#include "romano/base/endpoint.h"

namespace romano::net {

/// Needs CAP_NET_RAW.
[[nodiscard]] boost::system::error_code announce(const Endpoint& endpoint,
                                                 InterfaceIndex interface);

}  // namespace romano::net
