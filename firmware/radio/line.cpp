#include "firmware/radio/line.h"

#include <algorithm>
#include <cstring>

namespace romano::radio {

void Line::send(Instant now, const Datagram& datagram) {
    const Waiting head{datagram.peer, datagram.dbm,
                       static_cast<std::uint16_t>(datagram.octets.size())};
    if (datagram.octets.size() > 0xFFFF ||
        waiting_.size() - used_ < sizeof head + datagram.octets.size()) {
        ++lost_;
        return;
    }
    std::memcpy(&waiting_[used_], &head, sizeof head);
    std::copy(datagram.octets.begin(), datagram.octets.end(),
              waiting_.begin() + static_cast<std::ptrdiff_t>(used_ + sizeof head));
    used_ += sizeof head + datagram.octets.size();
    go_on(now);
}

bool Line::send_packet(Instant now, PacketType type, Bytes body) {
    std::array<std::uint8_t, max_packet> packet{};
    const std::size_t header = write_header(type, packet);
    if (!link_.is_idle() || body.size() > packet.size() - header) return false;
    std::copy(body.begin(), body.end(), packet.begin() + static_cast<std::ptrdiff_t>(header));
    return link_.send(now, Bytes{packet}.first(header + body.size()));
}

/// The next part of the first datagram, once the last one was acknowledged.
void Line::go_on(Instant now) {
    if (used_ == 0 || !link_.is_idle()) return;
    Waiting head;
    std::memcpy(&head, waiting_.data(), sizeof head);
    const Datagram datagram{head.peer, head.dbm, Bytes{waiting_}.subspan(sizeof head, head.size)};
    std::array<std::uint8_t, max_packet> packet{};
    const std::size_t size = write_part(sends_, datagram, part_, sent_, packet);
    (void)link_.send(now, Bytes{packet}.first(size));
    ++part_;
    if (sent_ < head.size) return;
    const std::size_t gone = sizeof head + head.size;
    std::copy(waiting_.begin() + static_cast<std::ptrdiff_t>(gone),
              waiting_.begin() + static_cast<std::ptrdiff_t>(used_), waiting_.begin());
    used_ -= gone;
    sent_ = 0;
    part_ = 0;
}

Line::Input Line::on_octet(Instant now, std::uint8_t octet) {
    const auto data = link_.on_octet(now, octet);
    go_on(now);  // it may have been the acknowledgement
    if (!data) return {};
    const auto packet = parse_packet(*data);
    if (!packet) return {};
    if (packet->type == PacketType::send_udp || packet->type == PacketType::forward_udp) {
        return {std::nullopt, parts_.on_part(packet->body)};
    }
    return {packet, std::nullopt};
}

void Line::on_tick(Instant now) {
    link_.on_tick(now);
}

}  // namespace romano::radio
