// What an IP packet takes on IEEE 802.15.4, computed: 6LoWPAN compression (RFC 6282), fragments
// (RFC 4944) and airtime, as overlay/radio has them; a test holds it against ns-3.
#pragma once

#include <cstddef>

namespace romano::bench::ros {

enum class Transport { udp, tcp };

struct RadioCost {
    double frames = 0;  // with data; each is acknowledged, unless it goes to everybody
    double air_ms = 0;  // acknowledgements included, waiting for the channel not

    RadioCost& operator+=(const RadioCost& other) {
        frames += other.frames;
        air_ms += other.air_ms;
        return *this;
    }
};

/// `octets`: behind the header of UDP, which is compressed; or with the header of TCP, which
/// nothing compresses.
[[nodiscard]] RadioCost radio_cost(Transport transport, std::size_t octets, bool to_everybody);

}  // namespace romano::bench::ros
