// What an operator wants of a robot, as the octets that this robot understands: the paper's
// messages, or the authors' firmware's ASCII. Throws std::invalid_argument with one sentence when
// it cannot be said.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "romano/server/node_entry.h"

namespace romano::experiments {

using Octets = std::vector<std::uint8_t>;
using server::Form;

/// "abcd1234,team/red": robots' ids, or topics that they listen to.
[[nodiscard]] std::vector<std::string> receivers_in(std::string_view list);
/// `movement`: front, back, left, right, rotate-left, rotate-right; or 0x8000 to 0xffff with
/// hexadecimal octets as `amount`. `amount`: "100mm", "10cm", "0.5m", "90deg", "1500mdeg"; for the
/// authors' firmware, which drives by time, "500ms" or "2s". `legacy_speed`: its motors' percent.
[[nodiscard]] Octets move_message(Form form, std::string_view movement, std::string_view amount,
                                  int legacy_speed);
[[nodiscard]] Octets subscribe_message(Form form, std::string_view topic);
[[nodiscard]] Octets unsubscribe_message(Form form, std::string_view topic);
/// "Publish that kind of data on that topic."
[[nodiscard]] Octets request_message(Form form, std::string_view topic, std::string_view data);

}  // namespace romano::experiments
