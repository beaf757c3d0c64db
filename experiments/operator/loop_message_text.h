// A message of a control loop as an object for people and programs, in the words of
// romano/control/README.md.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "romano/control/messages.h"

namespace romano::experiments {

/// {"type": "loop-command", "session": 7, "sequence": 3, "tick_us": 60000, "value": "00000064"}
[[nodiscard]] nlohmann::ordered_json to_json(const control::Message& message);

}  // namespace romano::experiments
