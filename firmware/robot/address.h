// The board's addresses and the cores'.
#pragma once

#include "firmware/robot/board.h"
#include "romano/base/endpoint.h"

namespace romano::firmware {

/// Family none is the discovery group.
[[nodiscard]] Endpoint endpoint_of(const romano_address& address);
[[nodiscard]] romano_address address_of(const Endpoint& endpoint);

}  // namespace romano::firmware
