#include "broker/daemon/service_addresses.h"

#include "broker/daemon/refusal.h"
#include "broker/net/endpoint_text.h"

namespace romano::daemon {

std::string why_not_served(const Endpoint& address, const boost::system::error_code& error) {
    namespace errc = boost::system::errc;
    std::string why = "cannot be served (" + error.message() + ")";
    if (error == errc::address_in_use) {
        why = "is in use by another program; choose a free port or stop that program";
    } else if (error == errc::address_not_available) {
        why = "is no address of this machine; choose one that `ip address` lists";
    } else if (error == errc::permission_denied) {
        why = "is not permitted to this user; choose a port from 1024 on";
    } else if (error == errc::address_family_not_supported) {
        why = "is of a family that this machine does not have; choose the other one of IPv4, IPv6";
    }
    return "--listen '" + net::to_text(address) + "': " + why;
}

boost::system::error_code serve_moved(net::UdpService& udp, net::MovedAddresses& moved,
                                      const Endpoint& address) {
    auto error = udp.open(address, net::Bind::beside);
    if (error == boost::system::errc::address_not_available) {
        error = moved.add(address);
        if (!error) {
            error = udp.open(address, net::Bind::beside);
            if (error) moved.take_back(address);
        }
    }
    if (!error) error = moved.lease_on(address);
    if (error) {
        udp.close(address);
    } else {
        moved.announce(address);
    }
    return error;
}

void join_discovery_groups(net::UdpService& udp, const Settings& settings) {
    for (const Endpoint& group : settings.discovery_groups) {
        if (const auto error = udp.join(group)) {
            throw Refusal(
                "--discovery-group '" + net::to_text(group) + "': the group cannot be joined (" +
                error.message() +
                "); check that the interface of the first --listen address can multicast");
        }
    }
}

}  // namespace romano::daemon
