// What controller and radio say to each other in HDLC frames: the header of the authors' firmware
// (source port, destination port, type; little-endian), and behind it our use of four of its types.
//
//     13 hwaddr_get   radio → controller   the robot's id, 8 octets
//     11 hwaddr_ack   controller → radio   nothing
//     12 send_udp     controller → radio   part of a datagram
//      8 forward_udp  radio → controller   part of a datagram
//
// A datagram that does not fit one frame comes in parts: an octet with the part's number, bit 7 set
// while more follow; in part 0 then the signal strength (signed dBm), the family (0, 4, 6) and the
// address and port (big-endian) of the other end; then octets of the datagram.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/hdlc/frame.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"

namespace romano::radio {

enum class PacketType : std::uint8_t {
    forward_udp = 8,
    hwaddr_ack = 11,
    send_udp = 12,
    hwaddr_get = 13,
};

/// The authors' frames hold two octets less than they say (the FCS).
inline constexpr std::size_t max_packet = hdlc::max_data - 2;
inline constexpr std::int8_t unknown_dbm = 127;

struct Packet {
    PacketType type{};
    Bytes body;
};
/// Empty when it is too short. The type may be none of ours.
[[nodiscard]] std::optional<Packet> parse_packet(Bytes frame_data);
/// Writes the header; returns its size. `out` holds it.
std::size_t write_header(PacketType type, MutableBytes out);

struct Datagram {
    Endpoint peer;  // family none: the discovery group
    std::int8_t dbm = unknown_dbm;
    Bytes octets;
};

/// Writes part `number` of the datagram as a whole packet, beginning at octet `at`, which it moves
/// on; returns the packet's size.
[[nodiscard]] std::size_t write_part(PacketType type, const Datagram& datagram, unsigned number,
                                     std::size_t& at, MutableBytes out);

/// Puts parts together, in room that the owner lends. A part that is out of turn, or too much,
/// ends the datagram: it is dropped and counted.
class Assembler {
public:
    explicit Assembler(MutableBytes room) : room_(room) {}
    /// The datagram that this part completes; valid until the next call.
    [[nodiscard]] std::optional<Datagram> on_part(Bytes body);
    [[nodiscard]] std::uint32_t dropped() const { return dropped_; }

private:
    bool begin(Bytes& body);
    std::optional<Datagram> drop();

    MutableBytes room_;
    Datagram datagram_;
    std::size_t size_ = 0;
    unsigned next_ = 0;
    std::uint32_t dropped_ = 0;
};

}  // namespace romano::radio
