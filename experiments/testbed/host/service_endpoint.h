// An address of the hosts file as the network's code takes it.
#pragma once

#include <optional>
#include <string>

#include "broker/net/endpoint_text.h"

namespace romano::experiments {

/// Its port is 1: who asks for addresses does not look at it. Empty when it is no IP address.
[[nodiscard]] inline std::optional<Endpoint> endpoint_at(const std::string& address) {
    const bool is_v6 = address.find(':') != std::string::npos;
    return net::parse_endpoint(is_v6 ? "[" + address + "]:1" : address + ":1");
}

}  // namespace romano::experiments
