// A loop's message on its way to the owner of a plant or of a controller.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "romano/base/bytes.h"
#include "romano/control/messages.h"
#include "romano/mqttsn/types.h"

namespace romano::control {

template <typename M, typename Port>
void send(const RomanoId& to, const M& message, mqttsn::Qos qos, Port& port) {
    std::array<std::uint8_t, largest_message> room;
    const std::size_t size = encode(message, room);
    if (size != 0) port.publish(to, Bytes{room}.first(size), qos);
}

}  // namespace romano::control
