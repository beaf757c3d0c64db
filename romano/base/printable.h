// Names in lines for people: a topic or a client id is whatever a client sends.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace romano {

/// Its first part. No octet of it ends the line or moves a terminal's cursor.
[[nodiscard]] inline std::string printable(std::string_view text) {
    constexpr std::size_t most = 100;
    std::string out;
    for (const char c : text.substr(0, most)) {
        const auto octet = static_cast<unsigned char>(c);
        out += octet < 0x20 || octet >= 0x7F ? '?' : c;
    }
    return text.size() > most ? out + "..." : out;
}

}  // namespace romano
