#include "bench/ros/tap.h"

#include <arpa/inet.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string>
#include <system_error>

#include "bench/ros/contestant.h"
#include "romano/base/bytes.h"

namespace romano::bench::ros {
namespace {

constexpr std::size_t ethernet_header = 14;
constexpr std::size_t arp_octets = 28;
constexpr std::size_t enough_of_frame = 128;  // all headers
constexpr int kept_octets = 64 * 1024 * 1024;
constexpr int bridge_host = 0;

int checked(int result, const char* what) {
    if (result < 0) throw std::system_error(errno, std::generic_category(), what);
    return result;
}

}  // namespace

// The LAN gives host n the address 10.60.0.n; what goes elsewhere goes to all. A service address
// that has moved counts as where it was: it is a broker's in either case.
std::optional<Packet> packet_in(int from, std::span<const std::uint8_t> frame) {
    if (frame.size() < ethernet_header + arp_octets) return std::nullopt;
    const std::uint16_t type = be16(frame, 12);
    const auto ip = frame.subspan(ethernet_header);
    if (type == ETH_P_ARP) return Packet{.from = from, .octets = arp_octets};
    if (type != ETH_P_IP || ip[0] >> 4U != 4) return std::nullopt;
    const std::size_t header = (ip[0] & 0x0FU) * std::size_t{4};
    Packet packet{.from = from, .octets = be16(ip, 2)};
    if (header < 20 || packet.octets < header) return std::nullopt;
    if (ip[16] == 10 && ip[17] == 60 && ip[18] == 0 && ip[19] != 255) {
        packet.to = ip[19] > first_service ? ip[19] - first_service : ip[19];
    }
    packet.transport_octets = packet.octets - static_cast<unsigned>(header);
    if (ip[9] == IPPROTO_TCP) packet.kind = Packet::Kind::tcp;
    const bool is_later_fragment = (be16(ip, 6) & 0x1FFFU) != 0;
    if (ip[9] == IPPROTO_UDP) {
        packet.kind = Packet::Kind::udp;
        if (!is_later_fragment && packet.transport_octets >= 8) packet.transport_octets -= 8;
    }
    return packet;
}

Tap::Tap(const experiments::Lan& lan, int hosts) {
    const experiments::Lan::On bridge(lan, bridge_host);
    socket_ =
        checked(::socket(AF_PACKET, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, htons(ETH_P_ALL)),
                "packet socket");
    checked(::setsockopt(socket_, SOL_SOCKET, SO_RCVBUFFORCE, &kept_octets, sizeof kept_octets),
            "SO_RCVBUFFORCE");
    for (int host = 1; host <= hosts; ++host) {
        const unsigned index = ::if_nametoindex(("port" + std::to_string(host)).c_str());
        host_of_port_.emplace(static_cast<int>(index), host);
    }
}

Tap::~Tap() {
    ::close(socket_);
}

std::vector<Packet> Tap::take() {
    std::vector<Packet> packets;
    std::array<std::uint8_t, enough_of_frame> room{};
    sockaddr_ll from{};
    socklen_t size = sizeof from;
    for (;;) {
        const ssize_t got = ::recvfrom(socket_, room.data(), room.size(), 0,
                                       reinterpret_cast<sockaddr*>(&from), &size);
        if (got <= 0) return packets;
        const auto host = host_of_port_.find(from.sll_ifindex);
        // Each frame once: where it enters the bridge.
        if (from.sll_pkttype == PACKET_OUTGOING || host == host_of_port_.end()) continue;
        const auto packet =
            packet_in(host->second, std::span{room}.first(static_cast<std::size_t>(got)));
        if (packet) packets.push_back(*packet);
    }
}

unsigned Tap::lost() const {
    tpacket_stats stats{};
    socklen_t size = sizeof stats;
    checked(::getsockopt(socket_, SOL_PACKET, PACKET_STATISTICS, &stats, &size),
            "PACKET_STATISTICS");
    return stats.tp_drops;
}

}  // namespace romano::bench::ros
