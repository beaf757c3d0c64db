// The peers' clients, who get what is published here as well as the own ones do.
#pragma once

#include <cstddef>
#include <string_view>

#include "broker/core/session_image.h"
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
    /// Another client is connected from this one's address, as far as is known: what comes from
    /// there to a service address where neither was heard may be of either.
    [[nodiscard]] virtual bool share_address_with(const SessionHeader& own) const = 0;
};

}  // namespace romano::broker
