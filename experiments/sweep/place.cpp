#include "experiments/sweep/place.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <utility>

namespace romano::experiments {
namespace {

constexpr int first_network = 50;
constexpr int networks = 50;

/// Every participant of a domain binds its discovery port (DDSI-RTPS 2.3, section 9.6.1.1), shared
/// among them; we do not share, and are refused.
bool is_silent(std::uint32_t domain) {
    const int probe = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(7400 + 250 * domain));
    const auto* any = reinterpret_cast<const sockaddr*>(&address);
    const bool bound = ::bind(probe, any, sizeof address) == 0;
    ::close(probe);
    return bound;
}

std::optional<NetworkPlace> claim_this_network(const std::string& network) {
    auto claim = Claim::on_name("network/" + network);
    if (!claim) return std::nullopt;
    return NetworkPlace{network, std::move(*claim)};
}

}  // namespace

std::optional<NetworkPlace> claim_network(const std::string& wanted) {
    if (!wanted.empty()) return claim_this_network(wanted);
    for (int i = 0; i < networks; ++i) {
        if (auto place = claim_this_network("127." + std::to_string(first_network + i))) {
            return place;
        }
    }
    return std::nullopt;
}

std::optional<DomainPlace> claim_domain(std::uint32_t base, std::uint32_t count,
                                        std::uint32_t first) {
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t domain = base + (first + i) % count;
        auto claim = Claim::on_name("domain/" + std::to_string(domain));
        if (claim && is_silent(domain)) return DomainPlace{domain, std::move(*claim)};
    }
    return std::nullopt;
}

}  // namespace romano::experiments
