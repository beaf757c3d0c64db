// Endpoints as people write them: "127.0.0.1:1883", "[::1]:1883", "[fe80::1%eth0]:1883"; service
// addresses of protected clients: "protected://127.0.0.1:1883".
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "romano/base/endpoint.h"

namespace romano::net {

/// An IP address and a port, no host names: a broker that waits for DNS does not serve.
[[nodiscard]] std::optional<Endpoint> parse_endpoint(std::string_view text);

/// The same, or with "protected://" in front.
[[nodiscard]] std::optional<Endpoint> parse_service_address(std::string_view text);

[[nodiscard]] std::string to_text(const Endpoint& endpoint);

}  // namespace romano::net
