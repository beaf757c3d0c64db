// All packets of a LAN of network namespaces, as its bridge sees them: from whom to whom, how long.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "experiments/process/lan.h"

namespace romano::bench::ros {

/// IPv4 and ARP. (IPv6 here is only the kernel's own.)
struct Packet {
    enum class Kind : std::uint8_t { udp, tcp, other };

    int from = 0;         // host
    int to = 0;           // host; 0: all
    unsigned octets = 0;  // from the IP header on
    Kind kind = Kind::other;
    unsigned transport_octets = 0;  // UDP: behind its header; TCP: with its header
};

/// `frame` as Ethernet has it: its first octets; it may be cut off behind the transport's header.
/// Empty when it is neither IPv4 nor ARP, or is broken.
[[nodiscard]] std::optional<Packet> packet_in(int from, std::span<const std::uint8_t> frame);

class Tap {
public:
    /// Hosts 1 to `hosts`. Throws std::system_error.
    Tap(const experiments::Lan& lan, int hosts);
    ~Tap();
    Tap(const Tap&) = delete;
    Tap& operator=(const Tap&) = delete;

    /// What came since the last call. Call often: the kernel keeps some megabytes.
    [[nodiscard]] std::vector<Packet> take();
    /// That the kernel had no room for; counted since the last call.
    [[nodiscard]] unsigned lost() const;

private:
    int socket_ = -1;
    std::map<int, int> host_of_port_;  // by the index of the interface
};

}  // namespace romano::bench::ros
