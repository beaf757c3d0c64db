#include "experiments/web/request_rules.h"

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <cctype>

namespace romano::experiments {
namespace {

std::string lower_case(std::string_view text) {
    std::string out{text};
    std::ranges::transform(out, out.begin(), [](unsigned char letter) {
        return static_cast<char>(std::tolower(letter));
    });
    return out;
}

/// "[::1]:8080" to "::1", "r1.local:8080" to "r1.local"; empty when it is neither.
std::string_view without_port(std::string_view host) {
    if (host.starts_with('[')) {
        const auto end = host.find(']');
        return end == std::string_view::npos ? std::string_view{} : host.substr(1, end - 1);
    }
    return host.substr(0, host.find(':'));
}

}  // namespace

bool is_own_host(std::string_view host, const std::vector<std::string>& names) {
    const std::string name = lower_case(without_port(host));
    boost::system::error_code is_no_address;
    (void)boost::asio::ip::make_address(name, is_no_address);
    if (!is_no_address) return true;
    return std::ranges::any_of(names,
                               [&](const std::string& own) { return lower_case(own) == name; });
}

std::optional<std::string> objection_to_change(const RequestFields& request) {
    if (!request.origin.empty() && request.origin != "http://" + request.host &&
        request.origin != "https://" + request.host) {
        return "this came from the page of another site (Origin): it may not steer robots";
    }
    if (!request.fetch_site.empty() && request.fetch_site != "same-origin" &&
        request.fetch_site != "none") {
        return "this came from the page of another site (Sec-Fetch-Site): it may not steer robots";
    }
    const std::string type = lower_case(request.content_type.substr(
        0, std::min(request.content_type.find(';'), request.content_type.size())));
    if (type != "application/json") {
        return "the content type must be application/json (curl: -H 'Content-Type: "
               "application/json')";
    }
    return std::nullopt;
}

}  // namespace romano::experiments
