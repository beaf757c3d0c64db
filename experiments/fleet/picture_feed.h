// What a client hears of a fleet, told to its picture: the states that brokers keep of themselves
// and of robots, and all other messages. The same for a watcher and for a recording.
#pragma once

#include <string_view>

#include "experiments/fleet/fleet_picture.h"
#include "romano/base/bytes.h"

namespace romano::experiments {

/// Of the echoes that each watcher sends to itself: <prefix><its client id>.
inline constexpr std::string_view echo_prefix = "romano-web/";

/// A watcher's echoes are nobody's message, and are passed over.
void tell_picture(FleetPicture& picture, Instant now, std::string_view topic, Bytes data);

}  // namespace romano::experiments
