// An address and a port as a setting's text.
#pragma once

#include <string>
#include <string_view>

#include "broker/daemon/refusal.h"
#include "broker/net/endpoint_text.h"

namespace romano::daemon {

/// Throws Refusal.
[[nodiscard]] inline Endpoint address_and_port(std::string_view option, const std::string& text) {
    const auto endpoint = net::parse_endpoint(text);
    if (!endpoint) {
        refuse_option(option, text,
                      "is no address and port; write ADDR:PORT, for example 127.0.0.1:1883 or "
                      "[::1]:1883");
    }
    return *endpoint;
}

}  // namespace romano::daemon
