// What an operator wants of a loop between two robots, as the octets that the plant understands,
// and what the plant reports, as people and programs read it. Throws std::invalid_argument with one
// sentence when it cannot be said.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "romano/control/messages.h"

namespace romano::experiments {

struct LawRequest {
    control::Law law{};
    std::vector<std::uint8_t> parameters;
};

/// `law`: follow (its parameter: `distance_mm`), go-to (`to`: "X,Y" in mm), or a number of the
/// application's own with `parameters` in hexadecimal.
[[nodiscard]] LawRequest law_request(std::string_view law, std::string_view parameters,
                                     std::uint32_t distance_mm, std::string_view to);

/// stop, hold or own-law.
[[nodiscard]] control::Fallback fallback_named(std::string_view name);

[[nodiscard]] message::RomanoId robot_id(std::string_view what, std::string_view text);

/// `controlled by 00000002: 500 samples, 499 carried out...`
[[nodiscard]] std::string to_line(const control::Report& report);
[[nodiscard]] nlohmann::ordered_json to_json(const control::Report& report);

}  // namespace romano::experiments
