#include "broker/daemon/default_name.h"

#include <ifaddrs.h>
#include <net/if.h>
#include <netpacket/packet.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <memory>

#include "broker/net/endpoint_text.h"
#include "broker/net/socket_address.h"

namespace romano::daemon {
namespace {

using Octets = std::array<unsigned char, 6>;

std::string hexadecimal(const Octets& octets) {
    std::string text;
    for (const unsigned char octet : octets) {
        std::array<char, 3> digits{};
        std::snprintf(digits.data(), digits.size(), "%02x", unsigned{octet});
        text += digits.data();
    }
    return text;
}

}  // namespace

std::string default_name(const std::string& host, const Endpoint& first,
                         const std::string& hardware) {
    const bool is_everywhere = net::is_wildcard(first) && !hardware.empty();
    const std::string where =
        is_everywhere ? hardware + ":" + std::to_string(first.port) : net::to_text(first);
    return host.substr(0, longest_name - where.size() - 1) + "-" + where;
}

std::string host_name() {
    std::array<char, 256> host{};
    if (gethostname(host.data(), host.size() - 1) != 0) return "broker";
    return host.data();
}

std::string hardware_address() {
    ifaddrs* all = nullptr;
    if (getifaddrs(&all) != 0) return {};
    const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> list(all, freeifaddrs);
    std::string found;
    for (const ifaddrs* entry = all; entry != nullptr; entry = entry->ifa_next) {
        if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_PACKET) continue;
        if ((entry->ifa_flags & IFF_LOOPBACK) != 0) continue;
        sockaddr_ll link{};
        std::memcpy(&link, entry->ifa_addr, sizeof link);
        Octets octets{};
        if (link.sll_halen != octets.size()) continue;
        std::ranges::copy_n(std::begin(link.sll_addr), octets.size(), octets.begin());
        if (octets == Octets{}) continue;
        // IEEE 802: this bit is set in addresses that software made up, anew at each boot.
        const bool is_of_its_maker = (octets[0] & 0x02U) == 0;
        if (is_of_its_maker) return hexadecimal(octets);
        if (found.empty()) found = hexadecimal(octets);
    }
    return found;
}

}  // namespace romano::daemon
