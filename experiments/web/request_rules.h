// Which HTTP requests are those of this page or of a program, and not of another page that the
// same browser shows: such a page can send requests to any address, under any name that it makes
// the browser resolve to it, and must neither read the fleet nor steer it.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace romano::experiments {

/// Header fields of a request; empty when it lacks them.
struct RequestFields {
    std::string host;
    std::string origin;
    std::string fetch_site;  // Sec-Fetch-Site, which browsers set and pages cannot
    std::string content_type;
};

/// An address or one of `names`, with or without a port. A page elsewhere that has its own name
/// resolved to this machine sends that name.
[[nodiscard]] bool is_own_host(std::string_view host, const std::vector<std::string>& names);

/// Why a request that changes something is refused, in a sentence; nothing when it may pass. JSON's
/// content type cannot be sent to another origin without asking first, which is not answered.
[[nodiscard]] std::optional<std::string> objection_to_change(const RequestFields& request);

}  // namespace romano::experiments
