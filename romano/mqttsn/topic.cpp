#include "romano/mqttsn/topic.h"

#include <cstddef>
#include <cstdint>

namespace romano::mqttsn {
namespace {

std::uint8_t octet_at(std::string_view text, std::size_t at) {
    return static_cast<std::uint8_t>(text[at]);
}

struct Utf8Lead {
    std::size_t continuations;   // octets that follow
    std::uint8_t second_lowest;  // the narrowed range of the first of them, which excludes overlong
    std::uint8_t second_highest;  // forms, surrogates and what lies beyond U+10FFFF
};

/// RFC 3629 section 4. No continuations: the octet does not begin a character of several octets.
constexpr Utf8Lead utf8_lead(std::uint8_t octet) {
    if (octet >= 0xC2 && octet <= 0xDF) return {1, 0x80, 0xBF};
    if (octet == 0xE0) return {2, 0xA0, 0xBF};
    if (octet == 0xED) return {2, 0x80, 0x9F};
    if (octet >= 0xE1 && octet <= 0xEF) return {2, 0x80, 0xBF};
    if (octet == 0xF0) return {3, 0x90, 0xBF};
    if (octet >= 0xF1 && octet <= 0xF3) return {3, 0x80, 0xBF};
    if (octet == 0xF4) return {3, 0x80, 0x8F};
    return {0, 0, 0};
}

/// The size of the character at `at`, or 0 when it is U+0000 or not well-formed UTF-8.
std::size_t character_size(std::string_view text, std::size_t at) {
    const std::uint8_t first = octet_at(text, at);
    if (first < 0x80) return first == 0 ? 0 : 1;
    const Utf8Lead lead = utf8_lead(first);
    if (lead.continuations == 0 || text.size() - at <= lead.continuations) return 0;
    const std::uint8_t second = octet_at(text, at + 1);
    if (second < lead.second_lowest || second > lead.second_highest) return 0;
    for (std::size_t i = 2; i <= lead.continuations; ++i) {
        if ((octet_at(text, at + i) & 0xC0U) != 0x80U) return 0;
    }
    return 1 + lead.continuations;
}

bool is_topic_text(std::string_view text) {
    if (text.empty()) return false;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t size = character_size(text, at);
        if (size == 0) return false;
        at += size;
    }
    return true;
}

bool fills_its_level(std::string_view filter, std::size_t at) {
    const bool begins = at == 0 || filter[at - 1] == '/';
    const bool ends = at + 1 == filter.size() || filter[at + 1] == '/';
    return begins && ends;
}

}  // namespace

bool is_valid_topic_name(std::string_view name) {
    return is_topic_text(name) && !has_wildcard(name);
}

bool is_valid_topic_filter(std::string_view filter) {
    if (!is_topic_text(filter)) return false;
    for (std::size_t at = 0; at < filter.size(); ++at) {
        if (filter[at] == '+' && !fills_its_level(filter, at)) return false;
        if (filter[at] == '#' && !(fills_its_level(filter, at) && at + 1 == filter.size())) {
            return false;
        }
    }
    return true;
}

bool has_wildcard(std::string_view filter) {
    for (const char c : filter) {
        if (c == '+' || c == '#') return true;
    }
    return false;
}

bool matches(std::string_view filter, std::string_view name) {
    if (!name.empty() && name[0] == '$' && (filter[0] == '+' || filter[0] == '#')) return false;
    std::size_t f = 0;
    std::size_t n = 0;
    while (f < filter.size()) {
        if (filter[f] == '#') return true;
        if (filter[f] == '+') {
            while (n < name.size() && name[n] != '/') ++n;
            ++f;
        } else if (n < name.size() && filter[f] == name[n]) {
            ++f;
            ++n;
        } else {
            // "a/#" matches "a": the rest of the filter is what names a's children.
            filter.remove_prefix(f);
            return n == name.size() && filter == "/#";
        }
    }
    return n == name.size();
}

}  // namespace romano::mqttsn
