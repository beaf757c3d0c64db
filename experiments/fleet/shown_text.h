// Texts that come from the network, as long as a person reads them: whoever may publish can name
// things with 60 KB, and what is kept of them must stay small.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "romano/base/bytes.h"

namespace romano::experiments {

inline constexpr std::size_t most_shown_octets = 120;

/// The text itself, or its beginning and how long it is: `aaaa… (61440 octets)`. Cut between two
/// letters of UTF-8. What it holds is not looked at: who shows it shows text.
[[nodiscard]] std::string shown_text(std::string_view text);

/// What came on `topic`, in one line: a ROMANO message in words, a text, or octets in hexadecimal.
[[nodiscard]] std::string shown_data(std::string_view topic, Bytes data);

}  // namespace romano::experiments
