// The fleet's picture as programs and the page read it. README.md of experiments/web has the keys.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "experiments/fleet/fleet_picture.h"

namespace romano::experiments {

/// {"version": 7, "watch": {...}, "cluster": {...}, "brokers": [...], "robots": [...],
/// "time_line": [...], "seconds": [...]}
[[nodiscard]] nlohmann::ordered_json to_json(const FleetPicture& picture);

/// The same with only those brokers, robots, happenings and seconds that are new or other than at
/// that version, and "left": robots that are none any more. Empty when too many have left since:
/// then the whole is due.
[[nodiscard]] std::optional<nlohmann::ordered_json> changes_since(const FleetPicture& picture,
                                                                  std::uint64_t version);

/// With its path and its last messages.
[[nodiscard]] nlohmann::ordered_json to_json(const FleetPicture& picture, const SeenRobot& robot);

}  // namespace romano::experiments
