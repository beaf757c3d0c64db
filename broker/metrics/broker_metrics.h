// What the broker core and its sockets counted, as metrics.
#pragma once

#include "broker/core/counters.h"
#include "broker/metrics/page.h"
#include "broker/net/core_timer.h"
#include "broker/net/net_counters.h"

namespace romano::metrics {

void add_messages(Page& page, const broker::Counters& counters);
void add_census(Page& page, const broker::Census& census);
void add_datagrams(Page& page, const net::NetCounters& counters);
void add_wakeups(Page& page, const net::CoreTimer& timer);
void add_turns(Page& page, const net::TurnClock& turns, Instant now);

}  // namespace romano::metrics
