// Opens the sockets of the settings, or says in one sentence why that is impossible.
#pragma once

#include <boost/system/error_code.hpp>
#include <string>

#include "broker/daemon/settings.h"
#include "broker/net/udp_service.h"

namespace romano::daemon {

/// "--listen '127.0.0.1:1883': the port is in use by another program; ..."
[[nodiscard]] std::string why_not_served(const Endpoint& address,
                                         const boost::system::error_code& error);

/// Throws Refusal.
void join_discovery_groups(net::UdpService& udp, const Settings& settings);

}  // namespace romano::daemon
