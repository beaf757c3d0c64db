// How large our smallest clients are on a Cortex-M3 (firmware/README.md, "Footprint"). The build
// reads it off their images, so that it is that of the sources beside it.
#pragma once

#include <optional>

namespace romano::bench::ros {

struct ClientSize {
    int flash_octets;
    int ram_octets;  // without stack
};

/// Empty where no arm-none-eabi-g++ built the image.
extern const std::optional<ClientSize> size_of_client;  // MQTT-SN client
extern const std::optional<ClientSize> size_of_node;    // and ROMANO node, mailbox, discovery

}  // namespace romano::bench::ros
