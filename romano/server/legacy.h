// The authors' firmware's side of the handshake: ASCII, the first octet is the type's digit, no
// length octet. Data is at most 31 octets without NUL.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "romano/base/bytes.h"
#include "romano/message/romano_id.h"

namespace romano::server::legacy {

/// Of init_info, the firmware's topic for the handshake.
struct Request {
    enum class Kind : std::uint8_t { hello, list, turn };
    Kind kind = Kind::hello;
    std::optional<message::RomanoId> id;  // `1`, the list, comes without
};

/// Empty when the data is none of `0`+id, `1`, `2`+id.
[[nodiscard]] std::optional<Request> parse(Bytes data);

/// MOVE_CMD, `7` and twelve hexadecimal digits, or RMT_CTRL, `8` and a key. The firmware reads no
/// further.
[[nodiscard]] bool is_movement(Bytes data);

inline constexpr std::string_view acknowledgement = "ACK";

/// `3` and one digit: how many nodes there are; the digit ends at 9.
[[nodiscard]] std::array<std::uint8_t, 2> count_message(std::size_t nodes);
/// `4` and one id.
[[nodiscard]] std::array<std::uint8_t, 9> node_message(const message::RomanoId& id);

}  // namespace romano::server::legacy
