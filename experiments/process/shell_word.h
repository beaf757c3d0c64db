// For a shell that gets a line: one word of it, whatever characters it has.
#pragma once

#include <string>

namespace romano::experiments {

[[nodiscard]] inline std::string shell_word(const std::string& word) {
    std::string text = "'";
    for (const char letter : word) {
        text += letter == '\'' ? std::string{"'\\''"} : std::string{letter};
    }
    return text + "'";
}

}  // namespace romano::experiments
