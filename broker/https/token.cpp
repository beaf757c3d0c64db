#include "broker/https/token.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <optional>

#include "romano/keys/key_error.h"
#include "romano/keys/private_file.h"

namespace romano::https {
namespace {

constexpr std::size_t most_characters = 256;

bool is_of_a_word(char letter) {  // b64token, RFC 6750 section 2.1
    return (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
           (letter >= '0' && letter <= '9') ||
           std::string_view{"-._~+/="}.find(letter) != std::string_view::npos;
}

/// What follows the name of a scheme, which may be written in any case.
std::optional<std::string_view> after_scheme(std::string_view text, std::string_view scheme) {
    if (text.size() <= scheme.size() || text[scheme.size()] != ' ') return std::nullopt;
    const auto is_same = [](char given, char lower) { return (given | 0x20) == lower; };
    if (!std::equal(scheme.begin(), scheme.end(), text.begin(),
                    [&](char lower, char given) { return is_same(given, lower); })) {
        return std::nullopt;
    }
    text.remove_prefix(std::min(text.find_first_not_of(' ', scheme.size()), text.size()));
    return text;
}

/// Of base64 "NAME:PASSWORD".
std::optional<std::string> password_in(std::string_view text) {
    constexpr std::size_t most = 1024;
    if (text.empty() || text.size() > most || text.size() % 4 != 0) return std::nullopt;
    std::array<unsigned char, most> octets{};
    const int size =
        EVP_DecodeBlock(octets.data(), reinterpret_cast<const unsigned char*>(text.data()),
                        static_cast<int>(text.size()));
    const auto padding = static_cast<int>(text.size() - 1 - text.find_last_not_of('='));
    if (size < 0 || padding > 2) return std::nullopt;
    const std::string pair(octets.begin(), octets.begin() + (size - padding));
    const auto colon = pair.find(':');
    if (colon == std::string::npos) return std::nullopt;
    return pair.substr(colon + 1);
}

}  // namespace

Token::Token(const std::filesystem::path& file) : word_(keys::read_private_file(file)) {
    word_.erase(std::min(word_.find_first_of("\r\n"), word_.size()));
    if (word_.size() < least_characters || word_.size() > most_characters ||
        !std::ranges::all_of(word_, is_of_a_word)) {
        throw keys::KeyError(
            file.string() +
            ": its first line is no token: 16 to 256 letters, digits, '-', '.', '_', '~', '+', '/' "
            "or '='; say: (umask 077; openssl rand -hex 16 > " +
            file.string() + ")");
    }
}

bool Token::is_shown_in(std::string_view authorization) const {
    const auto is_word = [this](std::string_view shown) {
        return shown.size() == word_.size() &&
               CRYPTO_memcmp(shown.data(), word_.data(), word_.size()) == 0;
    };
    if (const auto word = after_scheme(authorization, "bearer")) return is_word(*word);
    const auto pair = after_scheme(authorization, "basic");
    const auto password = pair ? password_in(*pair) : std::nullopt;
    return password && is_word(*password);
}

}  // namespace romano::https
