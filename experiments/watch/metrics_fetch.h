// Asks a broker for its page of metrics: over HTTP on its own machine, over HTTPS from elsewhere.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace romano::experiments {

struct MetricsAddress {
    std::string host;
    std::string port;
    bool is_https = false;
    std::optional<std::filesystem::path> authority = {};  // PEM; empty: whom the system believes
    std::optional<std::string> name = {};                 // in the certificate; empty: the host's
    std::optional<std::filesystem::path> token = {};
};

/// Of "HOST:PORT" or "https://HOST:PORT"; an IPv6 address stands in brackets.
[[nodiscard]] std::optional<MetricsAddress> parse_metrics_address(std::string_view text);

/// GET /metrics. Throws std::runtime_error with one sentence.
[[nodiscard]] std::string fetch_metrics(const MetricsAddress& address,
                                        std::chrono::milliseconds patience);

}  // namespace romano::experiments
