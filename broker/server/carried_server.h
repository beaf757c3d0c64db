// The ROMANO server as a broker carries it, alone or in a cluster: joins the server core to the
// broker core, which knows nothing of ROMANO.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "broker/core/broker_core.h"
#include "romano/base/bytes.h"
#include "romano/base/time.h"
#include "romano/server/server.h"

namespace romano::broker {

class CarriedServer {
public:
    /// What the broker core must tell of: BrokerOptions::observed_topics.
    [[nodiscard]] static std::vector<std::string> observed_topics();

    /// What it must not keep for later subscribers: BrokerOptions::never_retained.
    [[nodiscard]] static bool is_never_retained(std::string_view topic, Bytes payload);

    CarriedServer(const std::string& name, Duration unix_time_at_zero)
        : core_({.name = name, .unix_time_at_zero = unix_time_at_zero}) {}

    /// Answers what was observed in `actions`, with further actions of the broker.
    void answer(Instant now, BrokerCore& broker, Actions& actions);

    /// `led`: the members of the view that this broker leads; empty when it leads none.
    void on_tick(Instant now, BrokerCore& broker, std::span<const LogId> led, Actions& actions);
    [[nodiscard]] Instant next_wakeup() const { return core_.next_wakeup(); }

private:
    server::ServerCore core_;
};

}  // namespace romano::broker
