#include "broker/net/machine_address.h"

#include <ifaddrs.h>
#include <linux/capability.h>
#include <linux/if_addr.h>
#include <linux/ip.h>
#include <linux/neighbour.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <memory>
#include <string_view>

#include "broker/net/socket_address.h"

namespace romano::net {
namespace {

using boost::system::error_code;

error_code error_of(int number) {
    return {number, boost::system::system_category()};
}

std::size_t octets_of(const Endpoint& endpoint) {
    return endpoint.family == Endpoint::Family::ipv6 ? 16 : 4;
}

/// The octets of an IPv4 or IPv6 socket address, without its port.
const std::uint8_t* octets_of(const sockaddr* address) {
    const auto* start = reinterpret_cast<const std::uint8_t*>(address);
    return start + (address->sa_family == AF_INET6 ? offsetof(sockaddr_in6, sin6_addr)
                                                   : offsetof(sockaddr_in, sin_addr));
}

bool is_in_network_of(const ifaddrs& entry, const Endpoint& address) {
    const std::uint8_t* own = octets_of(entry.ifa_addr);
    const std::uint8_t* mask = octets_of(entry.ifa_netmask);
    bool any = false;  // a network of all addresses is none
    for (std::size_t i = 0; i < octets_of(address); ++i) {
        if (((own[i] ^ address.address[i]) & mask[i]) != 0) return false;
        any = any || mask[i] != 0;
    }
    return any;
}

/// One request to the kernel: header, body, attributes, without gaps.
template <typename Body>
class RouteRequest {
public:
    RouteRequest(std::uint16_t type, unsigned flags, const Body& body) {
        request_.header.nlmsg_len = offsetof(Request, attributes);
        request_.header.nlmsg_type = type;
        request_.header.nlmsg_flags = static_cast<std::uint16_t>(NLM_F_REQUEST | NLM_F_ACK | flags);
        request_.body = body;
    }

    void add(std::uint16_t type, const void* data, std::size_t size) {
        const rtattr head{.rta_len = static_cast<std::uint16_t>(sizeof(rtattr) + size),
                          .rta_type = type};
        const std::size_t at = request_.header.nlmsg_len - offsetof(Request, attributes);
        std::memcpy(&request_.attributes[at], &head, sizeof head);
        std::memcpy(&request_.attributes[at + sizeof head], data, size);
        request_.header.nlmsg_len += RTA_ALIGN(head.rta_len);
    }

    /// Asks, and waits for the kernel's answer, which comes at once.
    [[nodiscard]] error_code carry_out() const {
        const int fd = ::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
        if (fd < 0) return error_of(errno);
        const error_code error = exchange(fd);
        ::close(fd);
        return error;
    }

private:
    struct Request {
        nlmsghdr header;
        Body body;
        std::array<char, 128> attributes;
    };
    struct Answer {
        nlmsghdr header;
        nlmsgerr body;
        std::array<char, 512> request;  // the kernel may send it back
    };

    [[nodiscard]] error_code exchange(int fd) const {
        if (::send(fd, &request_, request_.header.nlmsg_len, 0) < 0) return error_of(errno);
        Answer answer{};
        const auto size = ::recv(fd, &answer, sizeof answer, 0);
        if (size < 0) return error_of(errno);
        if (static_cast<std::size_t>(size) < offsetof(Answer, request) ||
            answer.header.nlmsg_type != NLMSG_ERROR) {
            return error_of(EPROTO);
        }
        return error_of(-answer.body.error);
    }

    Request request_{};
};

RouteRequest<ifaddrmsg> about(const Endpoint& endpoint, InterfaceIndex interface,
                              std::uint16_t type, unsigned flags) {
    ifaddrmsg body{};
    body.ifa_family = endpoint.family == Endpoint::Family::ipv6 ? AF_INET6 : AF_INET;
    body.ifa_prefixlen = static_cast<std::uint8_t>(8 * octets_of(endpoint));
    body.ifa_index = static_cast<unsigned>(interface);
    RouteRequest<ifaddrmsg> request(type, flags, body);
    request.add(IFA_LOCAL, endpoint.address.data(), octets_of(endpoint));
    request.add(IFA_ADDRESS, endpoint.address.data(), octets_of(endpoint));
    return request;
}

/// One entry of the kernel's list: is it this very address, alone and for a while?
bool is_lease_of(const nlmsghdr& header, const char* octets, const Endpoint& endpoint) {
    ifaddrmsg body{};
    if (header.nlmsg_type != RTM_NEWADDR || header.nlmsg_len < sizeof header + sizeof body) {
        return false;
    }
    std::memcpy(&body, octets + sizeof header, sizeof body);
    if ((body.ifa_flags & IFA_F_PERMANENT) != 0) return false;
    if (body.ifa_prefixlen != 8 * octets_of(endpoint)) return false;
    for (std::size_t at = sizeof header + sizeof body; at + sizeof(rtattr) <= header.nlmsg_len;) {
        rtattr attribute{};
        std::memcpy(&attribute, octets + at, sizeof attribute);
        if (attribute.rta_len < sizeof attribute || at + attribute.rta_len > header.nlmsg_len)
            break;
        const std::size_t size = attribute.rta_len - sizeof attribute;
        if (attribute.rta_type == IFA_ADDRESS && size == octets_of(endpoint) &&
            std::memcmp(octets + at + sizeof attribute, endpoint.address.data(), size) == 0) {
            return true;
        }
        at += (attribute.rta_len + 3U) & ~3U;
    }
    return false;
}

/// Asks for all addresses of the family.
bool ask_for_list(int fd, const Endpoint& endpoint) {
    struct {
        nlmsghdr header;
        ifaddrmsg body;
    } request{};
    request.header.nlmsg_len = sizeof request;
    request.header.nlmsg_type = RTM_GETADDR;
    request.header.nlmsg_flags = NLM_F_REQUEST | NLM_F_DUMP;
    request.body.ifa_family = endpoint.family == Endpoint::Family::ipv6 ? AF_INET6 : AF_INET;
    return ::send(fd, &request, sizeof request, 0) > 0;
}

bool is_in_list(int fd, const Endpoint& endpoint) {
    std::array<char, 16'384> octets{};
    for (;;) {
        const auto received = ::recv(fd, octets.data(), octets.size(), 0);
        if (received <= 0) return false;
        const auto size = static_cast<std::size_t>(received);
        for (std::size_t at = 0; at + sizeof(nlmsghdr) <= size;) {
            nlmsghdr header{};
            std::memcpy(&header, octets.data() + at, sizeof header);
            if (header.nlmsg_len < sizeof header || at + header.nlmsg_len > size) return false;
            if (header.nlmsg_type == NLMSG_DONE || header.nlmsg_type == NLMSG_ERROR) return false;
            if (is_lease_of(header, octets.data() + at, endpoint)) return true;
            at += (header.nlmsg_len + 3U) & ~3U;
        }
    }
}

}  // namespace

bool is_leased(const Endpoint& endpoint) {
    const int fd = ::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
    if (fd < 0) return false;
    const bool found = ask_for_list(fd, endpoint) && is_in_list(fd, endpoint);
    ::close(fd);
    return found;
}

std::optional<InterfaceIndex> interface_towards(const Endpoint& address) {
    ifaddrs* all = nullptr;
    if (getifaddrs(&all) != 0) return std::nullopt;
    const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> list(all, freeifaddrs);
    const int family = address.family == Endpoint::Family::ipv6 ? AF_INET6 : AF_INET;
    for (const ifaddrs* entry = all; entry != nullptr; entry = entry->ifa_next) {
        if (entry->ifa_addr == nullptr || entry->ifa_netmask == nullptr) continue;
        if (entry->ifa_addr->sa_family != family) continue;
        if ((entry->ifa_flags & IFF_UP) == 0 || (entry->ifa_flags & IFF_LOOPBACK) != 0) continue;
        if (is_in_network_of(*entry, address))
            return InterfaceIndex{if_nametoindex(entry->ifa_name)};
    }
    return std::nullopt;
}

bool may_add_addresses() {
    __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
    std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> sets{};
    if (::syscall(SYS_capget, &header, sets.data()) != 0) return false;
    return (sets[CAP_TO_INDEX(CAP_NET_ADMIN)].effective & CAP_TO_MASK(CAP_NET_ADMIN)) != 0;
}

error_code add_address(const Endpoint& endpoint, InterfaceIndex interface,
                       std::chrono::seconds lease) {
    auto request = about(endpoint, interface, RTM_NEWADDR, NLM_F_CREATE | NLM_F_REPLACE);
    // Not preferred: nothing else of this machine shall speak from it.
    const ifa_cacheinfo lifetime{.ifa_prefered = 0,
                                 .ifa_valid = static_cast<std::uint32_t>(lease.count()),
                                 .cstamp = 0,
                                 .tstamp = 0};
    request.add(IFA_CACHEINFO, &lifetime, sizeof lifetime);
    // Usable at once, without asking around whether somebody has it: its broker is dead.
    const std::uint32_t flags = IFA_F_NODAD | IFA_F_NOPREFIXROUTE;
    request.add(IFA_FLAGS, &flags, sizeof flags);
    return request.carry_out();
}

error_code remove_address(const Endpoint& endpoint, InterfaceIndex interface) {
    return about(endpoint, interface, RTM_DELADDR, 0).carry_out();
}

error_code ask_neighbours_as_itself(InterfaceIndex interface) {
    struct {
        rtattr family;
        rtattr settings;
        rtattr arp_announce;
        std::uint32_t best_own_address;
    } ipv4{.family = {.rta_len = sizeof ipv4, .rta_type = AF_INET},
           .settings = {.rta_len = sizeof ipv4 - sizeof(rtattr), .rta_type = IFLA_INET_CONF},
           .arp_announce = {.rta_len = sizeof ipv4 - 2 * sizeof(rtattr),
                            .rta_type = IPV4_DEVCONF_ARP_ANNOUNCE},
           .best_own_address = 2};
    ifinfomsg body{};
    body.ifi_index = static_cast<int>(interface);
    RouteRequest<ifinfomsg> request(RTM_SETLINK, 0, body);
    request.add(IFLA_AF_SPEC, &ipv4, sizeof ipv4);
    return request.carry_out();
}

error_code ask_neighbours_again_after(std::chrono::milliseconds time, Endpoint::Family family,
                                      InterfaceIndex interface) {
    const bool v6 = family == Endpoint::Family::ipv6;
    struct {
        rtattr index_head;
        std::uint32_t index;
        rtattr time_head;
        std::array<std::uint32_t, 2> time_ms;  // 64 bits that stand where 32 may
    } settings{.index_head = {.rta_len = 8, .rta_type = NDTPA_IFINDEX},
               .index = static_cast<std::uint32_t>(interface),
               .time_head = {.rta_len = 12, .rta_type = NDTPA_RETRANS_TIME},
               .time_ms = {}};
    const auto time_ms = static_cast<std::uint64_t>(time.count());
    std::memcpy(settings.time_ms.data(), &time_ms, sizeof time_ms);
    ndtmsg body{};
    body.ndtm_family = v6 ? AF_INET6 : AF_INET;
    RouteRequest<ndtmsg> request(RTM_SETNEIGHTBL, 0, body);
    const std::string_view table = v6 ? "ndisc_cache" : "arp_cache";
    request.add(NDTA_NAME, table.data(), table.size() + 1);
    request.add(NDTA_PARMS, &settings, sizeof settings);
    return request.carry_out();
}

}  // namespace romano::net
