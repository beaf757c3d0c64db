#include "bench/ros/lowpan_cost.h"

#include <algorithm>

namespace romano::bench::ros {
namespace {

// Octets. Short addresses within one PAN; both addresses follow from them; ports in full.
constexpr std::size_t mac = 11;             // header 9, FCS 2
constexpr std::size_t most_in_frame = 114;  // of 116; what ns-3's device takes
constexpr std::size_t ip_header = 3;        // compressed: dispatch and hop limit
constexpr std::size_t group = 1;            // which of all groups
constexpr std::size_t next_header = 1;      // of TCP, in full
constexpr std::size_t udp_header = 7;       // compressed: dispatch, ports, checksum
constexpr std::size_t first_fragment = 4;
constexpr std::size_t other_fragment = 5;
constexpr std::size_t fragment_unit = 8;
constexpr std::size_t acknowledgement = 5;
constexpr std::size_t before_frame = 6;  // preamble, SFD, length
constexpr double ms_an_octet = 0.032;

double air_ms(std::size_t frame) {
    return static_cast<double>(before_frame + frame) * ms_an_octet;
}

}  // namespace

RadioCost radio_cost(Transport transport, std::size_t octets, bool to_everybody) {
    const std::size_t header = ip_header + (to_everybody ? group : 0) +
                               (transport == Transport::udp ? udp_header : next_header);
    RadioCost cost;
    const auto add_frame = [&](std::size_t content) {
        cost.frames += 1;
        cost.air_ms += air_ms(mac + content);
        if (!to_everybody) cost.air_ms += air_ms(acknowledgement);
    };
    if (header + octets <= most_in_frame) {
        add_frame(header + octets);
        return cost;
    }
    const auto whole_units = [](std::size_t room) { return room / fragment_unit * fragment_unit; };
    // The first one's offset counts the headers as they were: 48 octets, or 40, are whole units.
    std::size_t part = whole_units(most_in_frame - first_fragment - header);
    add_frame(first_fragment + header + part);
    for (std::size_t left = octets - part; left > 0; left -= part) {
        part = std::min(left, whole_units(most_in_frame - other_fragment));
        add_frame(other_fragment + part);
    }
    return cost;
}

}  // namespace romano::bench::ros
