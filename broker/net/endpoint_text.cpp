#include "broker/net/endpoint_text.h"

#include <arpa/inet.h>
#include <net/if.h>

#include <array>
#include <charconv>

#include "broker/net/socket_address.h"

namespace romano::net {
namespace {

constexpr std::string_view sealed_scheme = "protected://";
constexpr std::string_view dtls_scheme = "dtls://";

std::string_view scheme_of(Endpoint::Packets packets) {
    switch (packets) {
        case Endpoint::Packets::sealed:
            return sealed_scheme;
        case Endpoint::Packets::dtls:
            return dtls_scheme;
        case Endpoint::Packets::plain:
            break;
    }
    return {};
}

std::optional<std::uint16_t> parse_port(std::string_view text) {
    std::uint16_t port = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return port;
}

std::optional<Endpoint> parse_v6(std::string_view address, std::uint16_t port) {
    std::uint32_t interface = 0;
    if (const auto percent = address.find('%'); percent != std::string_view::npos) {
        interface = if_nametoindex(std::string(address.substr(percent + 1)).c_str());
        if (interface == 0) return std::nullopt;
        address = address.substr(0, percent);
    }
    in6_addr parsed{};
    if (inet_pton(AF_INET6, std::string(address).c_str(), &parsed) != 1) return std::nullopt;
    return to_endpoint(parsed, port, interface);
}

}  // namespace

std::optional<Endpoint> parse_endpoint(std::string_view text) {
    const auto colon = text.rfind(':');
    if (colon == std::string_view::npos) return std::nullopt;
    const auto port = parse_port(text.substr(colon + 1));
    if (!port) return std::nullopt;
    std::string_view address = text.substr(0, colon);
    if (address.size() >= 2 && address.front() == '[' && address.back() == ']') {
        return parse_v6(address.substr(1, address.size() - 2), *port);
    }
    in_addr parsed{};
    if (inet_pton(AF_INET, std::string(address).c_str(), &parsed) != 1) return std::nullopt;
    return to_endpoint(parsed, *port);
}

std::optional<Endpoint> parse_service_address(std::string_view text) {
    auto packets = Endpoint::Packets::plain;
    for (const auto each : {Endpoint::Packets::sealed, Endpoint::Packets::dtls}) {
        if (text.starts_with(scheme_of(each))) packets = each;
    }
    text.remove_prefix(scheme_of(packets).size());
    auto endpoint = parse_endpoint(text);
    if (endpoint) endpoint->packets = packets;
    return endpoint;
}

std::string to_text(const Endpoint& endpoint) {
    if (endpoint.packets != Endpoint::Packets::plain) {
        Endpoint plain = endpoint;
        plain.packets = Endpoint::Packets::plain;
        return std::string{scheme_of(endpoint.packets)} + to_text(plain);
    }
    const SocketAddress address = to_socket_address(endpoint);
    std::array<char, INET6_ADDRSTRLEN> text{};
    const std::string port = ":" + std::to_string(endpoint.port);
    switch (endpoint.family) {
        case Endpoint::Family::ipv4:
            inet_ntop(AF_INET, &address.v4.sin_addr, text.data(), text.size());
            return text.data() + port;
        case Endpoint::Family::ipv6: {
            inet_ntop(AF_INET6, &address.v6.sin6_addr, text.data(), text.size());
            std::string scope;
            if (endpoint.scope != 0) {
                std::array<char, IF_NAMESIZE> name{};
                const char* known = if_indextoname(endpoint.scope, name.data());
                scope =
                    "%" + (known != nullptr ? std::string(known) : std::to_string(endpoint.scope));
            }
            return "[" + std::string(text.data()) + scope + "]" + port;
        }
        case Endpoint::Family::none:
            break;
    }
    return "none";
}

}  // namespace romano::net
