// The paper's movements in words, by their number on the wire.
#pragma once

#include <array>
#include <string_view>

namespace romano::experiments {

inline constexpr std::array<std::string_view, 6> movements = {
    "front", "back", "left", "right", "rotate-left", "rotate-right"};

}  // namespace romano::experiments
