// Who else than the own clients gets what is published here: the peers' clients.
#pragma once

#include <cstddef>
#include <string_view>

#include "romano/base/time.h"

namespace romano::broker {

class Audience {
public:
    virtual ~Audience() = default;
    /// Asked before a message of QoS 0 is built for them.
    [[nodiscard]] virtual bool wants(std::string_view topic) const = 0;
    /// What waits at QoS 1 and 2 in the longest queue of those that want the topic and have taken a
    /// message after `since`. Short queues need not be told: 0.
    [[nodiscard]] virtual std::size_t longest_queue(std::string_view topic,
                                                    Instant since) const = 0;
};

}  // namespace romano::broker
