// A UART between a radio and its host, one direction of it: datagrams wait in a bounded queue and
// cross one after the other, ten bits an octet (8N1), framing, headers and stuffed octets included.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "overlay/sim/event_queue.h"
#include "overlay/sim/link.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"

namespace romano::radio {

/// An MQTT-SN datagram on its way.
struct Carried {
    sim::Node sender{};
    Endpoint from;
    Endpoint to;
    std::vector<std::uint8_t> octets;
};

struct Framing {
    std::size_t octets;         // around each part: flags, headers, FCS
    std::size_t part_max;       // octets of a datagram that fit one frame
    std::size_t answer_octets;  // an acknowledgement for which the next frame waits
};

/// Ethernet over serial, as RIOT's border routers speak it: IPv6 40, UDP 8, Ethernet 14, and two
/// flags and an FCS of HDLC. Nothing is acknowledged.
inline constexpr Framing ethernet_over_serial{66, 1452, 0};
/// The authors' robots: the packet's header 5, and the address, control, FCS and flags of HDLC.
/// Each frame is acknowledged by one without data.
inline constexpr Framing robots_hdlc{11, 57, 6};

class SerialLine {
public:
    /// False: the other end has no room, and this line waits for go_on().
    using Deliver = std::function<bool(const Carried&)>;

    /// `baud` empty: no line, both ends are one chip.
    SerialLine(sim::EventQueue& events, std::optional<std::uint32_t> baud, const Framing& framing,
               std::size_t room, Deliver deliver);

    /// False: no room for it, it is lost.
    bool send(Carried datagram);
    /// The other end has room again.
    void go_on();

    [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }
    [[nodiscard]] std::uint64_t lost() const { return lost_; }

private:
    void begin();
    void arrive();

    sim::EventQueue& events_;
    std::optional<std::uint32_t> baud_;
    Framing framing_;
    std::size_t room_;
    Deliver deliver_;
    std::deque<Carried> waiting_;  // the first one is on the line
    bool refused_ = false;
    std::uint64_t lost_ = 0;
};

/// How long a datagram is on the line, and how much later the next one may begin.
[[nodiscard]] Duration line_time(std::uint32_t baud, const Framing& framing, Bytes datagram);
[[nodiscard]] Duration answer_time(std::uint32_t baud, const Framing& framing);

}  // namespace romano::radio
