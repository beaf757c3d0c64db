#include "experiments/testbed/host/gather_facts.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <netpacket/packet.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <thread>

#include "broker/net/machine_address.h"
#include "broker/net/socket_address.h"
#include "experiments/process/program.h"
#include "experiments/sweep/build_info.h"
#include "experiments/testbed/host/machine_claim.h"
#include "experiments/testbed/host/network_cut.h"
#include "experiments/testbed/host/service_endpoint.h"

namespace romano::experiments {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr auto neighbour_answers_within = 1s;
constexpr std::uint16_t discard_port = 9;

/// A descriptor that is closed with its scope.
class Socket {
public:
    Socket(int family, int type) : handle_(::socket(family, type | SOCK_CLOEXEC, 0)) {}
    ~Socket() {
        if (handle_ >= 0) ::close(handle_);
    }
    Socket(const Socket&) = delete;
    Socket& operator=(const Socket&) = delete;
    [[nodiscard]] int handle() const { return handle_; }
    [[nodiscard]] bool is_open() const { return handle_ >= 0; }

private:
    int handle_;
};

std::string first_line(const std::string& text) {
    return text.substr(0, text.find('\n'));
}

/// SHA-256 of the files, as text.
std::string digest_of(const std::vector<std::string>& files) {
    std::istringstream lines(run_program("sha256sum", files).output);
    std::string digests;
    for (std::string digest, file; lines >> digest >> file;) digests += digest;
    return digests;
}

void look_at_programs(const fs::path& programs, HostFacts& facts) {
    utsname names{};
    (void)::uname(&names);
    facts.architecture = names.machine;
    const BuildInfo build = build_info();
    facts.version = std::string{build.version} + " (" + std::string{build.commit} + ")";
    // The one that needs most libraries.
    const fs::path member = programs / "romano-broker-member";
    const ProgramEnd end =
        run_program("/bin/sh", {"-c", "exec \"$0\" --version 2>&1", member.string()});
    facts.does_broker_run = end.ok();
    facts.broker_version = first_line(end.output);
    facts.broker_digest = digest_of({(programs / "romano-broker").string(), member.string()});
}

void look_at_interface(const FactsRequest& request, HostFacts& facts) {
    const Socket socket{AF_INET, SOCK_DGRAM};
    ifreq answer{};
    request.interface.copy(answer.ifr_name, IFNAMSIZ - 1);
    facts.has_interface = ::ioctl(socket.handle(), SIOCGIFFLAGS, &answer) == 0;
    if (!facts.has_interface) return;
    facts.is_up = (answer.ifr_flags & IFF_UP) != 0 && (answer.ifr_flags & IFF_RUNNING) != 0;
    facts.can_multicast = (answer.ifr_flags & IFF_MULTICAST) != 0;
    if (::ioctl(socket.handle(), SIOCGIFMTU, &answer) == 0) facts.mtu_octets = answer.ifr_mtu;
}

/// Of the interface, and the others' too if `of_all`.
std::vector<std::string> own_addresses(const std::string& interface, bool of_all) {
    std::vector<std::string> own;
    ifaddrs* all = nullptr;
    if (::getifaddrs(&all) != 0) return own;
    const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> list(all, ::freeifaddrs);
    for (const ifaddrs* entry = all; entry != nullptr; entry = entry->ifa_next) {
        if (entry->ifa_addr == nullptr || (!of_all && interface != entry->ifa_name)) continue;
        std::array<char, INET6_ADDRSTRLEN> text{};
        const void* octets = nullptr;
        if (entry->ifa_addr->sa_family == AF_INET) {
            octets = &reinterpret_cast<const sockaddr_in*>(entry->ifa_addr)->sin_addr;
        } else if (entry->ifa_addr->sa_family == AF_INET6) {
            octets = &reinterpret_cast<const sockaddr_in6*>(entry->ifa_addr)->sin6_addr;
        }
        if (octets == nullptr) continue;
        own.emplace_back(::inet_ntop(entry->ifa_addr->sa_family, octets, text.data(), text.size()));
    }
    return own;
}

/// The hardware address that the kernel knows for it; empty when nobody has answered.
std::string neighbour_at(const std::string& address) {
    std::istringstream words(run_program("ip", {"neighbour", "show", address}).output);
    for (std::string word; words >> word;) {
        if (word == "lladdr" && words >> word) return word;
    }
    return {};
}

/// Lets the kernel ask who has the address: a datagram to it must find its way.
void ask_for(const Endpoint& endpoint) {
    Endpoint to = endpoint;
    to.port = discard_port;
    const net::SocketAddress address = net::to_socket_address(to);
    const Socket socket{address.any.sa_family, SOCK_DGRAM};
    (void)::sendto(socket.handle(), "", 0, MSG_DONTWAIT, &address.any, address.size);
}

void look_at_addresses(const FactsRequest& request, HostFacts& facts) {
    facts.own_addresses = own_addresses(request.interface, false);
    const auto own = own_addresses(request.interface, true);
    const auto interface = net::InterfaceIndex{::if_nametoindex(request.interface.c_str())};
    bool is_asked = false;
    for (const std::string& address : request.addresses) {
        AddressFacts known{.address = address, .neighbour = {}};
        if (const auto endpoint = endpoint_at(address)) {
            known.is_own = std::ranges::count(own, address) > 0 && !net::is_leased(*endpoint);
            known.is_in_network = net::interface_towards(*endpoint) == interface;
            if (!known.is_own && known.is_in_network) {
                (void)run_program("ip", {"neighbour", "flush", "to", address});
                ask_for(*endpoint);
                is_asked = true;
            }
        }
        facts.addresses.push_back(known);
    }
    if (!is_asked) return;
    std::this_thread::sleep_for(neighbour_answers_within);
    for (AddressFacts& known : facts.addresses) {
        if (!known.is_own && known.is_in_network) known.neighbour = neighbour_at(known.address);
    }
}

/// "romano-broker (process 312)"; the kernel's table of UDP sockets names inodes, and processes
/// their descriptors.
std::string user_of_inode(const std::string& inode) {
    const std::string wanted = "socket:[" + inode + "]";
    std::error_code error;
    for (const auto& process : fs::directory_iterator("/proc", error)) {
        if (std::atoi(process.path().filename().c_str()) == 0) continue;
        std::error_code gone;
        for (fs::directory_iterator each(process.path() / "fd", gone), end; !gone && each != end;
             each.increment(gone)) {
            std::error_code unreadable;
            if (fs::read_symlink(each->path(), unreadable) != wanted) continue;
            std::ifstream comm(process.path() / "comm");
            std::string name;
            std::getline(comm, name);
            return name + " (process " + process.path().filename().string() + ")";
        }
    }
    return "another program";
}

std::string user_of_port(std::uint16_t port) {
    sockaddr_in any{};
    any.sin_family = AF_INET;
    any.sin_port = htons(port);
    const Socket probe{AF_INET, SOCK_DGRAM};
    if (::bind(probe.handle(), reinterpret_cast<const sockaddr*>(&any), sizeof any) == 0) return {};
    if (errno != EADDRINUSE) return std::string{"nobody, but: "} + std::strerror(errno);
    for (const char* table : {"/proc/net/udp", "/proc/net/udp6"}) {
        std::ifstream lines(table);
        std::string line;
        std::getline(lines, line);
        while (std::getline(lines, line)) {
            // sl local_address rem_address st queues tr retrnsmt uid timeout inode
            std::istringstream words(line);
            std::string number, local, word;
            words >> number >> local;
            for (int skipped = 0; skipped < 8 && words >> word; ++skipped) {
            }
            const std::size_t colon = local.find(':');
            if (colon == std::string::npos) continue;
            if (std::strtoul(local.c_str() + colon + 1, nullptr, 16) == port) {
                return user_of_inode(word);
            }
        }
    }
    return "another program";
}

}  // namespace

HostFacts gather_facts(const FactsRequest& request, const fs::path& programs) {
    HostFacts facts;
    facts.taken_by = who_has_the_machine();
    look_at_programs(programs, facts);
    look_at_interface(request, facts);
    facts.may_add_addresses = net::may_add_addresses();
    facts.may_announce = Socket{AF_PACKET, SOCK_RAW}.is_open();
    facts.may_cut = can_cut();
    look_at_addresses(request, facts);
    facts.port_user = user_of_port(request.port);
    std::error_code unknown;
    const fs::space_info space = fs::space("/tmp", unknown);
    if (!unknown) facts.free_mib = static_cast<std::int64_t>(space.available >> 20);
    return facts;
}

}  // namespace romano::experiments
