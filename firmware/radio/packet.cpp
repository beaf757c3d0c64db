#include "firmware/radio/packet.h"

#include <algorithm>

namespace romano::radio {
namespace {

constexpr std::size_t header_size = 5;
constexpr std::uint8_t controller_port = 200;
constexpr std::uint8_t radio_port = 170;
constexpr std::uint8_t more_follow = 0x80;
constexpr unsigned last_number = 0x7F;

std::size_t address_size(Endpoint::Family family) {
    return family == Endpoint::Family::ipv4 ? 4 : family == Endpoint::Family::ipv6 ? 16 : 0;
}

std::uint8_t family_octet(Endpoint::Family family) {
    return family == Endpoint::Family::ipv4 ? 4 : family == Endpoint::Family::ipv6 ? 6 : 0;
}

std::optional<Endpoint::Family> family_of(std::uint8_t octet) {
    if (octet == 0) return Endpoint::Family::none;
    if (octet == 4) return Endpoint::Family::ipv4;
    if (octet == 6) return Endpoint::Family::ipv6;
    return std::nullopt;
}

}  // namespace

std::optional<Packet> parse_packet(Bytes frame_data) {
    if (frame_data.size() < header_size) return std::nullopt;
    return Packet{PacketType{frame_data[4]}, frame_data.subspan(header_size)};
}

std::size_t write_header(PacketType type, MutableBytes out) {
    const bool to_radio = type == PacketType::send_udp || type == PacketType::hwaddr_ack;
    out[0] = to_radio ? controller_port : radio_port;
    out[1] = 0;
    out[2] = to_radio ? radio_port : controller_port;
    out[3] = 0;
    out[4] = static_cast<std::uint8_t>(type);
    return header_size;
}

std::size_t write_part(PacketType type, const Datagram& datagram, unsigned number, std::size_t& at,
                       MutableBytes out) {
    std::size_t size = write_header(type, out);
    const std::size_t number_at = size++;
    if (number == 0) {
        const Endpoint& peer = datagram.peer;
        out[size++] = static_cast<std::uint8_t>(datagram.dbm);
        out[size++] = family_octet(peer.family);
        const std::size_t address = address_size(peer.family);
        std::copy_n(peer.address.begin(), address, out.begin() + static_cast<std::ptrdiff_t>(size));
        size += address;
        if (address != 0) {
            put_be16(out, size, peer.port);
            size += 2;
        }
    }
    const std::size_t taken = std::min(datagram.octets.size() - at, max_packet - size);
    std::copy_n(datagram.octets.begin() + static_cast<std::ptrdiff_t>(at), taken,
                out.begin() + static_cast<std::ptrdiff_t>(size));
    at += taken;
    const bool more = at < datagram.octets.size();
    out[number_at] = static_cast<std::uint8_t>((number & last_number) | (more ? more_follow : 0U));
    return size + taken;
}

std::optional<Datagram> Assembler::drop() {
    next_ = 0;
    ++dropped_;
    return std::nullopt;
}

bool Assembler::begin(Bytes& body) {
    size_ = 0;
    if (body.size() < 2) return false;
    const auto family = family_of(body[1]);
    if (!family) return false;
    datagram_ = {};
    datagram_.dbm = static_cast<std::int8_t>(body[0]);
    datagram_.peer.family = *family;
    body = body.subspan(2);
    const std::size_t address = address_size(*family);
    if (address == 0) return true;
    if (body.size() < address + 2) return false;
    std::copy_n(body.begin(), address, datagram_.peer.address.begin());
    datagram_.peer.port = be16(body, address);
    body = body.subspan(address + 2);
    return true;
}

std::optional<Datagram> Assembler::on_part(Bytes body) {
    if (body.empty()) return drop();
    const unsigned number = body[0] & last_number;
    const bool more = (body[0] & more_follow) != 0;
    body = body.subspan(1);
    if (number == 0) {
        if (next_ != 0) ++dropped_;  // the one before it never ended
        if (!begin(body)) return drop();
    } else if (number != next_) {
        return drop();
    }
    if (body.size() > room_.size() - size_) return drop();
    std::copy(body.begin(), body.end(), room_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += body.size();
    next_ = number + 1;
    if (more) return next_ <= last_number ? std::nullopt : drop();
    next_ = 0;
    datagram_.octets = Bytes{room_}.first(size_);
    return datagram_;
}

}  // namespace romano::radio
