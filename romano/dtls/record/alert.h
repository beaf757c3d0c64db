// Alerts (RFC 5246 section 7.2), as far as they end an association.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "romano/base/bytes.h"

namespace romano::dtls {

enum class Alert : std::uint8_t {
    goodbye,  // close_notify, to be answered by the same (section 7.2.1)
    fatal,
    warning,  // ends nothing
};

/// What says goodbye.
inline constexpr std::array<std::uint8_t, 2> goodbye{1, 0};

/// Nothing when it is none.
[[nodiscard]] constexpr std::optional<Alert> alert_in(Bytes message) {
    constexpr std::uint8_t fatal = 2;
    if (message.size() != goodbye.size()) return std::nullopt;
    if (message[1] == goodbye[1]) return Alert::goodbye;
    return message[0] == fatal ? Alert::fatal : Alert::warning;
}

}  // namespace romano::dtls
