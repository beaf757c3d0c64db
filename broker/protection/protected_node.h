// How a client that proved who it is looks to the broker core: a node behind a forwarder (MQTT-SN
// 1.2 section 5.5) at a service address of protected packets or DTLS, whose wireless node id says
// whose key it spoke with.
#pragma once

#include <string>
#include <string_view>

#include "romano/base/endpoint.h"

namespace romano::broker {

// No forwarder calls its nodes so; plain datagrams that do are dropped by who has keys.
inline constexpr std::string_view protected_mark = "protected:";

[[nodiscard]] inline std::string protected_node_id(std::string_view client_id) {
    return std::string{protected_mark}.append(client_id);
}

[[nodiscard]] inline bool is_sealed(const Endpoint& via) {
    return via.packets == Endpoint::Packets::sealed;
}

[[nodiscard]] inline bool is_dtls(const Endpoint& via) {
    return via.packets == Endpoint::Packets::dtls;
}

/// Whoever speaks there has proved who it is.
[[nodiscard]] inline bool is_authenticated(const Endpoint& via) {
    return is_sealed(via) || is_dtls(via);
}

/// The client id that its key stands for; empty when there is none.
[[nodiscard]] inline std::string_view authenticated_id(const Endpoint& via,
                                                       std::string_view node_id) {
    if (!is_authenticated(via) || !node_id.starts_with(protected_mark)) return {};
    return node_id.substr(protected_mark.size());
}

}  // namespace romano::broker
