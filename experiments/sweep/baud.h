// The axes `router_baud` and `robot_baud` as a UART's baud.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace romano::experiments {

/// "none" is no line. The text is one that the sweep file took.
[[nodiscard]] inline std::optional<std::uint32_t> baud_of(const std::string& axis) {
    if (axis == "none") return std::nullopt;
    return static_cast<std::uint32_t>(std::stoul(axis));
}

}  // namespace romano::experiments
