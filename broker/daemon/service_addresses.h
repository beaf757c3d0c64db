// Opens the sockets of the settings, or says in one sentence why that is impossible.
#pragma once

#include <boost/system/error_code.hpp>
#include <string>

#include "broker/daemon/settings.h"
#include "broker/net/moved_addresses.h"
#include "broker/net/udp_service.h"

namespace romano::daemon {

/// "--listen '127.0.0.1:1883': the port is in use by another program; ..."
[[nodiscard]] std::string why_not_served(const Endpoint& address,
                                         const boost::system::error_code& error);

/// Serves an address that comes from a peer; gives it to the machine first when that lacks it.
[[nodiscard]] boost::system::error_code serve_moved(net::UdpService& udp,
                                                    net::MovedAddresses& moved,
                                                    const Endpoint& address);

/// Throws Refusal.
void join_discovery_groups(net::UdpService& udp, const Settings& settings);

}  // namespace romano::daemon
