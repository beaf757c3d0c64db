#include "romano/protection/packet.h"

#include <algorithm>
#include <cstring>

#include "romano/mqttsn/frame.h"
#include "romano/protection/packet_cipher.h"

namespace romano::protection {
namespace {

// The flags: the tag has the scheme's own size (0x1), no key material (0), a counter of 32 bits
// (2).
constexpr std::uint8_t flags = 0x12;
constexpr std::uint8_t scheme = 0x40;  // AES-CCM-64-128

constexpr std::size_t smallest_message = 2;  // length and type

std::uint32_t be32(Bytes octets, std::size_t at) {
    return std::uint32_t{be16(octets, at)} << 16U | be16(octets, at + 2);
}

void put_be32(MutableBytes octets, std::size_t at, std::uint32_t value) {
    put_be16(octets, at, static_cast<std::uint16_t>(value >> 16U));
    put_be16(octets, at + 2, static_cast<std::uint16_t>(value & 0xFFFFU));
}

}  // namespace

SenderId sender_id(std::string_view client_id) {
    const Nonce hash = nonce_of(as_octets(client_id));  // begins as its SHA-256 does
    SenderId id;
    std::copy_n(hash.begin(), id.size(), id.begin());
    return id;
}

Result<Packet, Refusal> parse(MutableBytes datagram) {
    const auto frame = mqttsn::decode_frame(datagram);
    if (!frame) return Refusal::malformed;
    if (frame->type != packet_type) return Refusal::unprotected;
    const Bytes body = frame->body;
    if (body.size() < fields_size + smallest_message + tag_size) return Refusal::malformed;
    if (body[0] != flags || body[1] != scheme) return Refusal::unknown_scheme;
    const std::size_t sealed_size = body.size() - fields_size;
    return Packet{.header = datagram.first(datagram.size() - sealed_size),
                  .sealed = datagram.last(sealed_size)};
}

Fields Packet::fields() const {
    const Bytes octets = header.last(fields_size - 2);
    Fields read;
    std::copy_n(octets.begin(), read.sender.size(), read.sender.begin());
    read.run = RunId{be32(octets, 8)};
    read.number = be32(octets, 12);
    return read;
}

std::size_t write(const Fields& fields, Bytes message, const Key& key, MutableBytes out) {
    const std::size_t body_size = fields_size + message.size() + tag_size;
    const std::size_t size = mqttsn::framed_size(body_size);
    if (message.empty() || size > out.size() || size > 0xFFFF) return 0;
    out = out.first(size);
    const std::size_t header_size = size - tag_size - message.size();
    const MutableBytes sealed = out.subspan(header_size, message.size());
    std::memmove(sealed.data(), message.data(), message.size());
    const MutableBytes body{mqttsn::begin_frame(packet_type, body_size, out), body_size};
    body[0] = flags;
    body[1] = scheme;
    std::copy(fields.sender.begin(), fields.sender.end(), body.begin() + 2);
    put_be32(body, 10, static_cast<std::uint32_t>(fields.run));
    put_be32(body, 14, fields.number);
    seal(key, out.first(header_size), sealed, out.last(tag_size));
    return size;
}

bool open(const Packet& packet, const Key& key) {
    return open(key, packet.header, packet.message(), packet.tag());
}

}  // namespace romano::protection
