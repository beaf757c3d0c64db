// One end of the line between controller and radio: datagrams in parts over the reliable HDLC link.
// Datagrams to send wait in room that the owner lends; when it is full they are lost, as on any
// network. No heap; the owner moves octets and time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/hdlc/link.h"
#include "firmware/radio/packet.h"
#include "romano/base/bytes.h"
#include "romano/base/time.h"

namespace romano::radio {

class Line {
public:
    /// `sends`: send_udp at the controller, forward_udp at the radio.
    Line(PacketType sends, MutableBytes room_to_send, MutableBytes room_to_receive,
         Duration repeat_after)
        : link_(repeat_after), sends_(sends), waiting_(room_to_send), parts_(room_to_receive) {}

    void send(Instant now, const Datagram& datagram);
    /// A packet of a few octets besides; false while the link is busy.
    [[nodiscard]] bool send_packet(Instant now, PacketType type, Bytes body);

    /// The packet or datagram that the octet completes; valid until the next call.
    struct Input {
        std::optional<Packet> packet;  // of a type that is no part of a datagram
        std::optional<Datagram> datagram;
    };
    [[nodiscard]] Input on_octet(Instant now, std::uint8_t octet);

    void on_tick(Instant now);
    [[nodiscard]] Instant next_wakeup() const { return link_.next_wakeup(); }

    /// Octets to write to the line since the last clear_line_out().
    [[nodiscard]] Bytes line_out() const { return link_.line_out(); }
    void clear_line_out() { link_.clear_line_out(); }

    [[nodiscard]] const hdlc::Link& link() const { return link_; }
    [[nodiscard]] std::uint32_t lost() const { return lost_; }

private:
    struct Waiting {
        Endpoint peer;
        std::int8_t dbm;
        std::uint16_t size;
    };
    void go_on(Instant now);

    hdlc::Link link_;
    PacketType sends_;
    MutableBytes waiting_;  // for each datagram: a Waiting, its octets
    std::size_t used_ = 0;
    std::size_t sent_ = 0;  // octets of the first one
    unsigned part_ = 0;
    Assembler parts_;
    std::uint32_t lost_ = 0;
};

}  // namespace romano::radio
