// What a broker tells Prometheus, as tests ask it.
#pragma once

#include <chrono>
#include <string>

#include "romano/base/endpoint.h"

namespace romano::system {

/// The whole answer to GET /metrics; empty when nobody serves there.
[[nodiscard]] std::string metrics_page_at(const Endpoint& address);

/// Waits until a series, written as on the page (`name` or `name{label="value"}`), is between the
/// two.
[[nodiscard]] bool metrics_come_to_say(const Endpoint& address, const std::string& series,
                                       double at_least, double at_most = 1e9);

}  // namespace romano::system
