// The process itself, under the names that Prometheus's own clients use.
#pragma once

#include <string_view>

#include "broker/metrics/page.h"

namespace romano::metrics {

/// `start`: the wall clock when it began, in seconds since the epoch.
void add_process(Page& page, std::string_view broker_name, std::string_view version, double start);

}  // namespace romano::metrics
