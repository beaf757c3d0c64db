// The broker core's options as the settings and this machine's clocks have them.
#pragma once

#include "broker/core/limits.h"
#include "broker/daemon/settings.h"

namespace romano::daemon {

/// The log's incarnation is the wall clock, or the least of the settings: higher at each start.
[[nodiscard]] broker::BrokerOptions broker_options(const Settings& settings);

/// A number that differs from run to run.
[[nodiscard]] std::uint64_t random_seed();

}  // namespace romano::daemon
