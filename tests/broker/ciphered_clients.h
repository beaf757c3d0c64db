// What the tests of ciphered listeners say to a broker core, and what it sends.
#pragma once

#include <cstdint>
#include <string_view>
#include <variant>
#include <vector>

#include "broker/core/actions.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/mqttsn/codec.h"

namespace romano::broker::test {

using Octets = std::vector<std::uint8_t>;

inline Endpoint endpoint(std::uint8_t host, std::uint16_t port) {
    Endpoint out;
    out.family = Endpoint::Family::ipv4;
    out.address = {192, 0, 2, host};
    out.port = port;
    return out;
}

template <typename M>
Octets octets_of(const M& message) {
    Octets out(300);
    out.resize(mqttsn::encode(message, out));
    return out;
}
inline Octets connect_as(std::string_view id) {
    return octets_of(mqttsn::Connect{false, true, mqttsn::protocol_id, 60, id});
}
inline const Octets ping = octets_of(mqttsn::Pingreq{""});

struct Sent {
    Endpoint to;
    Octets octets;
};

/// The datagrams that go to clients, as they leave.
inline std::vector<Sent> sent_to_clients(const Actions& actions) {
    std::vector<Sent> sent;
    for (const Action& action : actions.list()) {
        const auto* send = std::get_if<Send>(&action);
        if (send == nullptr || send->via.family == Endpoint::Family::none) continue;
        const Bytes octets = actions.octets(*send);
        sent.push_back({send->to.endpoint, {octets.begin(), octets.end()}});
    }
    return sent;
}

}  // namespace romano::broker::test
