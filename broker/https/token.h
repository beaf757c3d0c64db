// What whoever asks over HTTP must show: a word that both sides keep in a file of their own.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace romano::https {

class Token {
public:
    static constexpr std::size_t least_characters = 16;
    /// For a refusal (401): browsers then ask people for a name and a password.
    static constexpr const char* challenge = R"(Basic realm="romano", charset="UTF-8")";

    /// The first line of a file that nobody but its owner may read. Throws keys::KeyError.
    explicit Token(const std::filesystem::path& file);

    /// A request's Authorization has it: as a program says it, "Bearer WORD" (RFC 6750), or as a
    /// browser does, the password of "Basic", with any name (RFC 7617). How long the answer takes
    /// tells nothing of the word but its length.
    [[nodiscard]] bool is_shown_in(std::string_view authorization) const;
    /// For a request's Authorization.
    [[nodiscard]] std::string authorization() const { return "Bearer " + word_; }

private:
    std::string word_;
};

}  // namespace romano::https
