// What happened to datagrams below the broker core, for people and for metrics.
#pragma once

#include <cstdint>

#include "broker/net/latency_histogram.h"

namespace romano::net {

struct NetCounters {
    std::uint64_t received = 0;
    std::uint64_t sent = 0;
    std::uint64_t send_buffer_full = 0;  // dropped: UDP may, and QoS 1 and 2 are sent again
    std::uint64_t send_failed = 0;       // dropped: no route, too large for the path
    std::uint64_t no_such_socket = 0;    // dropped: from an address that is served no more
    LatencyHistogram handling;           // from a batch being read to its answers being sent
};

}  // namespace romano::net
