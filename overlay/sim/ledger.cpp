#include "overlay/sim/ledger.h"

#include <charconv>

namespace romano::sim {

namespace {
constexpr std::size_t payload_octets = 32;
const std::string will_prefix = "will ";
}  // namespace

std::string to_payload(const std::string& publisher, std::uint32_t number) {
    std::string payload = publisher + ' ' + std::to_string(number) + ' ';
    if (payload.size() < payload_octets) payload.resize(payload_octets, '.');
    return payload;
}

std::optional<std::pair<std::string, std::uint32_t>> from_payload(const std::string& payload) {
    const auto name_end = payload.find(' ');
    if (name_end == std::string::npos) return std::nullopt;
    std::uint32_t number = 0;
    const char* begin = payload.data() + name_end + 1;
    const auto [end, error] = std::from_chars(begin, payload.data() + payload.size(), number);
    if (error != std::errc{} || end == payload.data() + payload.size() || *end != ' ') {
        return std::nullopt;
    }
    return std::pair{payload.substr(0, name_end), number};
}

std::string will_payload(const std::string& robot) {
    return will_prefix + robot;
}

std::optional<std::string> from_will_payload(const std::string& payload) {
    if (!payload.starts_with(will_prefix)) return std::nullopt;
    return payload.substr(will_prefix.size());
}

}  // namespace romano::sim
