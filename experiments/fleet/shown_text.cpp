#include "experiments/fleet/shown_text.h"

#include "experiments/operator/message_text.h"

namespace romano::experiments {
namespace {

bool continues_a_letter(char octet) {
    return (static_cast<unsigned char>(octet) & 0xC0U) == 0x80U;
}

}  // namespace

std::string shown_text(std::string_view text) {
    if (text.size() <= most_shown_octets) return std::string{text};
    constexpr std::size_t longest_letter = 4;
    std::size_t end = most_shown_octets;
    while (end > most_shown_octets - longest_letter && continues_a_letter(text[end])) --end;
    return std::string{text.substr(0, end)} + "… (" + std::to_string(text.size()) + " octets)";
}

std::string shown_data(std::string_view topic, Bytes data) {
    if (const auto message = romano_message(topic, data)) return shown_text(to_line(*message));
    if (is_text(data)) return shown_text(as_text(data));
    constexpr std::size_t most = most_shown_octets / 2;
    if (data.size() <= most) return hexadecimal(data);
    return hexadecimal(data.first(most)) + "… (" + std::to_string(data.size()) + " octets)";
}

}  // namespace romano::experiments
