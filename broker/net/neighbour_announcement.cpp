#include "broker/net/neighbour_announcement.h"

#include <net/ethernet.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <netinet/icmp6.h>
#include <netpacket/packet.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <vector>

#include "broker/net/last_error.h"
#include "broker/net/socket_address.h"

namespace romano::net {
namespace {

using boost::system::error_code;
using Mac = std::array<std::uint8_t, ETH_ALEN>;

class Socket {
public:
    Socket(int family, int type, int protocol)
        : fd_(::socket(family, type | SOCK_CLOEXEC, protocol)) {}
    ~Socket() {
        if (fd_ >= 0) ::close(fd_);
    }
    Socket(const Socket&) = delete;
    Socket& operator=(const Socket&) = delete;
    [[nodiscard]] int fd() const { return fd_; }

private:
    int fd_;
};

std::optional<Mac> mac_of(int socket, InterfaceIndex interface) {
    ifreq request{};
    if (if_indextoname(static_cast<unsigned>(interface), request.ifr_name) == nullptr) return {};
    if (::ioctl(socket, SIOCGIFHWADDR, &request) != 0) return {};
    Mac mac{};
    std::memcpy(mac.data(), request.ifr_hwaddr.sa_data, mac.size());
    return mac;
}

void append(std::vector<std::uint8_t>& packet, std::initializer_list<std::uint8_t> octets) {
    packet.insert(packet.end(), octets);
}

template <typename Octets>
void append(std::vector<std::uint8_t>& packet, const Octets& octets, std::size_t count) {
    packet.insert(packet.end(), octets.begin(),
                  octets.begin() + static_cast<std::ptrdiff_t>(count));
}

/// RFC 826: "I, at this hardware address, have this IP address", to nobody in particular.
std::vector<std::uint8_t> arp(std::uint8_t operation, const Mac& mac, const Endpoint& endpoint) {
    std::vector<std::uint8_t> packet;
    append(packet, {0, 1, 0x08, 0x00, 6, 4, 0, operation});  // Ethernet, IPv4, sizes, operation
    append(packet, mac, mac.size());
    append(packet, endpoint.address, 4);
    append(packet, {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF});
    append(packet, endpoint.address, 4);
    return packet;
}

error_code announce_ipv6(const Endpoint& endpoint, InterfaceIndex interface) {
    const Socket socket(AF_INET6, SOCK_RAW, IPPROTO_ICMPV6);
    if (socket.fd() < 0) return last_error();
    const auto mac = mac_of(socket.fd(), interface);
    if (!mac) return last_error();
    Endpoint source = endpoint;
    source.port = 0;
    source.scope = static_cast<std::uint32_t>(interface);
    const SocketAddress from = to_socket_address(source);
    const int index = static_cast<int>(interface);
    const int hops = 255;  // section 7.1.2: a router's packet would have fewer
    if (::bind(socket.fd(), &from.any, from.size) != 0 ||
        ::setsockopt(socket.fd(), IPPROTO_IPV6, IPV6_MULTICAST_IF, &index, sizeof index) != 0 ||
        ::setsockopt(socket.fd(), IPPROTO_IPV6, IPV6_MULTICAST_HOPS, &hops, sizeof hops) != 0) {
        return last_error();
    }
    std::vector<std::uint8_t> packet;
    append(packet, {ND_NEIGHBOR_ADVERT, 0, 0, 0});  // the kernel fills the checksum in
    append(packet, {0x20, 0, 0, 0});                // override what you know
    append(packet, endpoint.address, 16);
    append(packet, {ND_OPT_TARGET_LINKADDR, 1});
    append(packet, *mac, mac->size());
    sockaddr_in6 all_nodes{};
    all_nodes.sin6_family = AF_INET6;
    all_nodes.sin6_addr = {{{0xFF, 0x02, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}}};
    all_nodes.sin6_scope_id = static_cast<std::uint32_t>(interface);
    if (::sendto(socket.fd(), packet.data(), packet.size(), 0,
                 reinterpret_cast<const sockaddr*>(&all_nodes), sizeof all_nodes) < 0) {
        return last_error();
    }
    return {};
}

}  // namespace

NeighbourAnnouncer::~NeighbourAnnouncer() {
    if (packet_socket_ >= 0) ::close(packet_socket_);
}

error_code NeighbourAnnouncer::announce_ipv4(const Endpoint& endpoint, InterfaceIndex interface) {
    // Of no protocol: it only sends.
    if (packet_socket_ < 0) packet_socket_ = ::socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (packet_socket_ < 0) return last_error();
    const auto mac = mac_of(packet_socket_, interface);
    if (!mac) return last_error();
    sockaddr_ll everybody{};
    everybody.sll_family = AF_PACKET;
    everybody.sll_protocol = htons(ETH_P_ARP);
    everybody.sll_ifindex = static_cast<int>(interface);
    everybody.sll_halen = ETH_ALEN;
    std::fill_n(everybody.sll_addr, ETH_ALEN, std::uint8_t{0xFF});
    // Some systems heed requests only, others replies only.
    for (const int operation : {ARPOP_REQUEST, ARPOP_REPLY}) {
        const auto packet = arp(static_cast<std::uint8_t>(operation), *mac, endpoint);
        if (::sendto(packet_socket_, packet.data(), packet.size(), 0,
                     reinterpret_cast<const sockaddr*>(&everybody), sizeof everybody) < 0) {
            return last_error();
        }
    }
    return {};
}

error_code NeighbourAnnouncer::announce(const Endpoint& endpoint, InterfaceIndex interface) {
    return endpoint.family == Endpoint::Family::ipv6 ? announce_ipv6(endpoint, interface)
                                                     : announce_ipv4(endpoint, interface);
}

}  // namespace romano::net
