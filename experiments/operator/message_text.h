// A ROMANO message as people and programs read it: a JSON object with its fields in the paper's
// words and units, or the same in one line.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "romano/message/codec.h"

namespace romano::experiments {

/// What came on `topic`, when it is a ROMANO message. The application's own types (0x13 on) are
/// told from other octets on ROMANO's own topics only: init-info, common, a robot's id.
[[nodiscard]] std::optional<message::Message> romano_message(std::string_view topic, Bytes data);

/// {"type": "movement-control", "movement": "front", "mm": 100}
[[nodiscard]] nlohmann::ordered_json to_json(const message::Message& message);
/// `movement-control movement=front mm=100`
[[nodiscard]] std::string to_line(const message::Message& message);

[[nodiscard]] std::string hexadecimal(Bytes octets);
/// Without a control character or octets that are no UTF-8: fit for a terminal.
[[nodiscard]] bool is_text(Bytes octets);

}  // namespace romano::experiments
