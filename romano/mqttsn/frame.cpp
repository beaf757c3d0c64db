#include "romano/mqttsn/frame.h"

namespace romano::mqttsn {
namespace {

constexpr std::uint8_t long_form = 0x01;
constexpr std::size_t short_header = 2;  // length, type
constexpr std::size_t long_header = 4;   // 0x01, length of two octets, type

/// Section 5.5: the length is always one octet and counts only the forwarder's own header; the
/// wrapped message has a length of its own.
Decoded<Frame> decode_wrapping(Bytes datagram) {
    const std::size_t header = datagram[0];
    if (header < short_header || header > datagram.size()) return Malformed::length;
    return Frame{MsgType::encapsulated, datagram.subspan(short_header, header - short_header),
                 datagram.subspan(header)};
}

/// Paho's MQTTSNPacket.c does not count the two octets that the long form adds where it just begins
/// to use it: length 255 in a datagram of 257 or, by its version, 256 in one of 258. Exactly these
/// are let through.
constexpr bool is_uncounted_long_form(std::size_t length, std::size_t datagram) {
    return (length == 255 || length == 256) && datagram == length + 2;
}

}  // namespace

Decoded<Frame> decode_frame(Bytes datagram) {
    if (datagram.empty()) return Malformed::empty;
    const bool is_long = datagram[0] == long_form;
    const std::size_t header = is_long ? long_header : short_header;
    if (datagram.size() < header) return Malformed::length;
    const auto type = static_cast<MsgType>(datagram[header - 1]);
    if (type == MsgType::encapsulated) {  // never in the long form (5.5)
        return is_long ? Malformed::length : decode_wrapping(datagram);
    }
    const std::size_t length = is_long ? be16(datagram, 1) : datagram[0];
    const bool is_true =
        length == datagram.size() || (is_long && is_uncounted_long_form(length, datagram.size()));
    if (!is_true) return Malformed::length;
    return Frame{type, datagram.subspan(header), {}};
}

std::uint8_t* begin_frame(MsgType type, std::size_t body_size, MutableBytes out) {
    const std::size_t size = framed_size(body_size);
    if (size > out.size() || size > 0xFFFF) return nullptr;
    if (size == body_size + short_header) {
        out[0] = static_cast<std::uint8_t>(size);
        out[1] = static_cast<std::uint8_t>(type);
        return out.data() + short_header;
    }
    out[0] = long_form;
    put_be16(out, 1, static_cast<std::uint16_t>(size));
    out[3] = static_cast<std::uint8_t>(type);
    return out.data() + long_header;
}

}  // namespace romano::mqttsn
