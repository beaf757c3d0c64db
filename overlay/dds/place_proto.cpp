#include "overlay/dds/place_proto.h"

#include <algorithm>

namespace romano::overlay::proto {

void to_proto(const romano::Endpoint& in, Endpoint& out) {
    switch (in.family) {
        case romano::Endpoint::Family::none:
            return;
        case romano::Endpoint::Family::ipv4:
            out.set_address(in.address.data(), 4);
            break;
        case romano::Endpoint::Family::ipv6:
            out.set_address(in.address.data(), 16);
            break;
    }
    out.set_port(in.port);
    out.set_scope(in.scope);
    out.set_sealed(in.packets == romano::Endpoint::Packets::sealed);
    out.set_dtls(in.packets == romano::Endpoint::Packets::dtls);
}

std::optional<romano::Endpoint> from_proto(const Endpoint& in) {
    romano::Endpoint out;
    const Bytes address = as_octets(in.address());
    switch (address.size()) {
        case 0:
            return out;
        case 4:
            out.family = romano::Endpoint::Family::ipv4;
            break;
        case 16:
            out.family = romano::Endpoint::Family::ipv6;
            break;
        default:
            return std::nullopt;
    }
    const auto port = narrow<std::uint16_t>(in.port());
    if (!port) return std::nullopt;
    std::ranges::copy(address, out.address.begin());
    out.port = *port;
    out.scope = in.scope();
    if (in.sealed()) out.packets = romano::Endpoint::Packets::sealed;
    if (in.dtls()) out.packets = romano::Endpoint::Packets::dtls;
    return out;
}

void to_proto(const broker::LogId& in, LogId& out) {
    out.set_broker(static_cast<std::uint64_t>(in.broker));
    out.set_incarnation(in.incarnation);
}

std::optional<broker::LogId> from_proto(const LogId& in) {
    return broker::LogId{broker::BrokerId{in.broker()}, in.incarnation()};
}

void to_proto(const broker::LogPosition& in, LogPosition& out) {
    out.set_broker(static_cast<std::uint64_t>(in.log.broker));
    out.set_incarnation(in.log.incarnation);
    out.set_seq(in.seq);
}

std::optional<broker::LogPosition> from_proto(const LogPosition& in) {
    return broker::LogPosition{{broker::BrokerId{in.broker()}, in.incarnation()}, in.seq()};
}

}  // namespace romano::overlay::proto
