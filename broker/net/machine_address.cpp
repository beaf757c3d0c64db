#include "broker/net/machine_address.h"

#include <ifaddrs.h>
#include <libmnl/libmnl.h>
#include <linux/capability.h>
#include <linux/if_addr.h>
#include <linux/ip.h>
#include <linux/neighbour.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <memory>

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

/// One request to the kernel, which answers at once.
class RouteRequest {
public:
    template <typename Body>
    RouteRequest(std::uint16_t type, unsigned flags, const Body& body) {
        nlmsghdr& start = *mnl_nlmsg_put_header(octets_.data());
        start.nlmsg_type = type;
        start.nlmsg_flags = static_cast<std::uint16_t>(NLM_F_REQUEST | flags);
        std::memcpy(mnl_nlmsg_put_extra_header(&start, sizeof body), &body, sizeof body);
    }
    /// For mnl_attr_put() and its kin.
    [[nodiscard]] nlmsghdr* header() { return reinterpret_cast<nlmsghdr*>(octets_.data()); }

    /// `on_entry` is called for each entry of an answer that is a list.
    [[nodiscard]] error_code carry_out(mnl_cb_t on_entry = nullptr, void* data = nullptr) {
        const std::unique_ptr<mnl_socket, int (*)(mnl_socket*)> socket{
            mnl_socket_open2(NETLINK_ROUTE, SOCK_CLOEXEC), mnl_socket_close};
        if (!socket || mnl_socket_sendto(socket.get(), header(), header()->nlmsg_len) < 0) {
            return error_of(errno);
        }
        alignas(nlmsghdr) std::array<char, 16'384> answer;
        for (int state = MNL_CB_OK; state != MNL_CB_STOP;) {
            const auto size = mnl_socket_recvfrom(socket.get(), answer.data(), answer.size());
            if (size < 0) return error_of(errno);
            state = mnl_cb_run(answer.data(), static_cast<std::size_t>(size), 0, 0, on_entry, data);
            if (state < MNL_CB_STOP) return error_of(errno);
        }
        return {};
    }

private:
    alignas(nlmsghdr) std::array<char, 256> octets_;
};

int family_of(const Endpoint& endpoint) {
    return endpoint.family == Endpoint::Family::ipv6 ? AF_INET6 : AF_INET;
}

RouteRequest about(const Endpoint& endpoint, InterfaceIndex interface, std::uint16_t type,
                   unsigned flags) {
    ifaddrmsg body{};
    body.ifa_family = static_cast<std::uint8_t>(family_of(endpoint));
    body.ifa_prefixlen = static_cast<std::uint8_t>(8 * octets_of(endpoint));
    body.ifa_index = static_cast<unsigned>(interface);
    RouteRequest request(type, NLM_F_ACK | flags, body);
    for (const std::uint16_t name : {IFA_LOCAL, IFA_ADDRESS}) {
        mnl_attr_put(request.header(), name, octets_of(endpoint), endpoint.address.data());
    }
    return request;
}

struct LeaseSearch {
    const Endpoint& endpoint;
    bool found = false;
};

struct Entry {
    const Endpoint& wanted;
    bool is_wanted = false;
    std::uint32_t flags = 0;
};

int read_attribute(const nlattr* attribute, void* data) {
    auto& entry = *static_cast<Entry*>(data);
    const std::size_t size = octets_of(entry.wanted);
    const std::size_t given = mnl_attr_get_payload_len(attribute);
    if (mnl_attr_get_type(attribute) == IFA_ADDRESS && given == size) {
        entry.is_wanted =
            std::memcmp(mnl_attr_get_payload(attribute), entry.wanted.address.data(), size) == 0;
    } else if (mnl_attr_get_type(attribute) == IFA_FLAGS && given == sizeof entry.flags) {
        entry.flags = mnl_attr_get_u32(attribute);
    }
    return MNL_CB_OK;
}

/// One entry of the kernel's list: is it this very address, as add_address() makes it? One that
/// DHCP gave may be alone and for a while, too, but it is preferred.
int compare_entry(const nlmsghdr* header, void* data) {
    auto& search = *static_cast<LeaseSearch*>(data);
    if (mnl_nlmsg_get_payload_len(header) < sizeof(ifaddrmsg)) return MNL_CB_OK;
    const auto& fixed = *static_cast<const ifaddrmsg*>(mnl_nlmsg_get_payload(header));
    if (fixed.ifa_prefixlen != 8 * octets_of(search.endpoint)) return MNL_CB_OK;
    Entry entry{search.endpoint};
    (void)mnl_attr_parse(header, sizeof fixed, read_attribute, &entry);
    constexpr std::uint32_t ours = IFA_F_DEPRECATED | IFA_F_NOPREFIXROUTE;
    const bool is_ours = (entry.flags & (ours | IFA_F_PERMANENT)) == ours;
    search.found = search.found || (entry.is_wanted && is_ours);
    return MNL_CB_OK;
}

}  // namespace

bool is_leased(const Endpoint& endpoint) {
    ifaddrmsg body{};
    body.ifa_family = static_cast<std::uint8_t>(family_of(endpoint));
    LeaseSearch search{endpoint};
    RouteRequest all(RTM_GETADDR, NLM_F_DUMP, body);
    return !all.carry_out(compare_entry, &search) && search.found;
}

std::optional<InterfaceIndex> interface_towards(const Endpoint& address) {
    ifaddrs* all = nullptr;
    if (getifaddrs(&all) != 0) return std::nullopt;
    const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> list(all, freeifaddrs);
    for (const ifaddrs* entry = all; entry != nullptr; entry = entry->ifa_next) {
        if (entry->ifa_addr == nullptr || entry->ifa_netmask == nullptr) continue;
        if (entry->ifa_addr->sa_family != family_of(address)) continue;
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
    mnl_attr_put(request.header(), IFA_CACHEINFO, sizeof lifetime, &lifetime);
    // Usable at once, without asking around whether somebody has it: its broker is dead.
    mnl_attr_put_u32(request.header(), IFA_FLAGS, IFA_F_NODAD | IFA_F_NOPREFIXROUTE);
    return request.carry_out();
}

error_code remove_address(const Endpoint& endpoint, InterfaceIndex interface) {
    return about(endpoint, interface, RTM_DELADDR, 0).carry_out();
}

error_code ask_neighbours_as_itself(InterfaceIndex interface) {
    constexpr std::uint32_t best_own_address = 2;
    ifinfomsg body{};
    body.ifi_index = static_cast<int>(interface);
    RouteRequest request(RTM_SETLINK, NLM_F_ACK, body);
    nlmsghdr* header = request.header();
    nlattr* families = mnl_attr_nest_start(header, IFLA_AF_SPEC);
    nlattr* ipv4 = mnl_attr_nest_start(header, AF_INET);
    nlattr* settings = mnl_attr_nest_start(header, IFLA_INET_CONF);
    mnl_attr_put_u32(header, IPV4_DEVCONF_ARP_ANNOUNCE, best_own_address);
    for (nlattr* nest : {settings, ipv4, families}) mnl_attr_nest_end(header, nest);
    return request.carry_out();
}

error_code ask_neighbours_again_after(std::chrono::milliseconds time, Endpoint::Family family,
                                      InterfaceIndex interface) {
    const bool v6 = family == Endpoint::Family::ipv6;
    ndtmsg body{};
    body.ndtm_family = v6 ? AF_INET6 : AF_INET;
    RouteRequest request(RTM_SETNEIGHTBL, NLM_F_ACK, body);
    nlmsghdr* header = request.header();
    mnl_attr_put_strz(header, NDTA_NAME, v6 ? "ndisc_cache" : "arp_cache");
    nlattr* settings = mnl_attr_nest_start(header, NDTA_PARMS);
    mnl_attr_put_u32(header, NDTPA_IFINDEX, static_cast<std::uint32_t>(interface));
    mnl_attr_put_u64(header, NDTPA_RETRANS_TIME, static_cast<std::uint64_t>(time.count()));
    mnl_attr_nest_end(header, settings);
    return request.carry_out();
}

}  // namespace romano::net
