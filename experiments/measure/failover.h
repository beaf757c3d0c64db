// Failover as its victims see it: from the fault to the first message that reaches a client of the
// struck broker, at that client's unchanged address.
//
// Only messages published after the fault count: what was in a socket's buffer already when the
// broker died must not pass for a recovery. A client to which nobody published after the fault has
// nothing to hear, and is left out.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "experiments/measure/delivery_account.h"

namespace romano::experiments {

struct ClientFailover {
    RobotNumber client;
    std::optional<double> after_ms{};  // empty: nothing reached it until the run's end
    bool was_addressed = false;        // by a message that was published after the fault
};

[[nodiscard]] std::vector<ClientFailover> client_failovers(const DeliveryAccount& account,
                                                           std::span<const RobotNumber> victims,
                                                           double fault_at_s);

}  // namespace romano::experiments
