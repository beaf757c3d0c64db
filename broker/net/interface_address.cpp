#include "broker/net/interface_address.h"

#include <ifaddrs.h>
#include <net/if.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>

#include "broker/net/socket_address.h"

namespace romano::net {
namespace {

/// The better interface has more of these.
int quality_of(const ifaddrs& entry) {
    const auto has = [&](unsigned flag) { return (entry.ifa_flags & flag) != 0 ? 1 : 0; };
    const int not_loopback = 1 - has(IFF_LOOPBACK);
    const int is_ipv4 = entry.ifa_addr->sa_family == AF_INET ? 1 : 0;
    return 4 * not_loopback + 2 * has(IFF_MULTICAST) + is_ipv4;
}

Endpoint address_of(const ifaddrs& entry) {
    SocketAddress address;
    const bool v6 = entry.ifa_addr->sa_family == AF_INET6;
    address.size = v6 ? sizeof(sockaddr_in6) : sizeof(sockaddr_in);
    std::memcpy(&address.v6, entry.ifa_addr, address.size);
    Endpoint endpoint = to_endpoint(address);
    endpoint.port = 0;
    return endpoint;
}

using AddressList = std::unique_ptr<ifaddrs, void (*)(ifaddrs*)>;

AddressList all_addresses() {
    ifaddrs* all = nullptr;
    if (getifaddrs(&all) != 0) all = nullptr;
    return {all, freeifaddrs};
}

}  // namespace

Endpoint interface_address(const std::string& interface) {
    const auto list = all_addresses();
    Endpoint best;
    int best_quality = -1;
    for (const ifaddrs* entry = list.get(); entry != nullptr; entry = entry->ifa_next) {
        if (entry->ifa_addr == nullptr || (entry->ifa_flags & IFF_UP) == 0) continue;
        const auto family = entry->ifa_addr->sa_family;
        if (family != AF_INET && family != AF_INET6) continue;
        if (!interface.empty() && interface != entry->ifa_name) continue;
        const int quality = quality_of(*entry);
        if (quality <= best_quality) continue;
        best = address_of(*entry);
        best_quality = quality;
    }
    return best;
}

std::vector<std::uint32_t> links_of(const Endpoint& served) {
    const auto list = all_addresses();
    std::vector<std::uint32_t> links;
    std::vector<std::uint32_t> loopbacks;
    const int family = served.family == Endpoint::Family::ipv6 ? AF_INET6 : AF_INET;
    for (const ifaddrs* entry = list.get(); entry != nullptr; entry = entry->ifa_next) {
        if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != family) continue;
        if ((entry->ifa_flags & IFF_UP) == 0) continue;
        const std::uint32_t link = if_nametoindex(entry->ifa_name);
        if (!is_wildcard(served)) {
            Endpoint own = address_of(*entry);
            own.port = served.port;
            if (own == served) return {link};
            continue;
        }
        const bool is_loopback = (entry->ifa_flags & IFF_LOOPBACK) != 0;
        if (!is_loopback && (entry->ifa_flags & IFF_MULTICAST) == 0) continue;
        auto& to = is_loopback ? loopbacks : links;
        if (std::ranges::count(to, link) == 0) to.push_back(link);
    }
    return links.empty() ? loopbacks : links;
}

}  // namespace romano::net
