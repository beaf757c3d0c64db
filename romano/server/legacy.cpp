#include "romano/server/legacy.h"

#include <algorithm>

namespace romano::server::legacy {

std::optional<Request> parse(Bytes data) {
    const std::string_view text = as_text(data);
    if (text == "1") return Request{Request::Kind::list, std::nullopt};
    if (text.empty() || (text[0] != '0' && text[0] != '2')) return std::nullopt;
    const auto id = message::RomanoId::parse(text.substr(1));
    if (!id) return std::nullopt;
    return Request{text[0] == '0' ? Request::Kind::hello : Request::Kind::turn, id};
}

bool is_movement(Bytes data) {
    constexpr std::string_view digits = "0123456789abcdefABCDEF";
    constexpr std::string_view keys = "wasd";
    const std::string_view text = as_text(data);
    if (text.size() >= 2 && text[0] == '8') return keys.find(text[1]) != keys.npos;
    return text.size() >= 13 && text[0] == '7' &&
           text.substr(1, 12).find_first_not_of(digits) == text.npos;
}

std::array<std::uint8_t, 2> count_message(std::size_t nodes) {
    return {'3', static_cast<std::uint8_t>('0' + std::min<std::size_t>(nodes, 9))};
}

std::array<std::uint8_t, 9> node_message(const message::RomanoId& id) {
    std::array<std::uint8_t, 9> out{'4'};
    std::ranges::copy(as_octets(id.text()), out.begin() + 1);
    return out;
}

}  // namespace romano::server::legacy
