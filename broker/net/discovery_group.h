// The multicast groups of MQTT-SN discovery (MQTT-SN 1.2 section 6.1; port and groups are not
// standardised, so they are settings: Paho's tools use 225.1.1.1:1883).
#pragma once

#include <vector>

#include "romano/base/endpoint.h"

namespace romano::net {

/// What most tools use, one group a family: 225.1.1.1:1883 and [ff02::225:1:1:1]:1883.
[[nodiscard]] std::vector<Endpoint> usual_discovery_groups();

}  // namespace romano::net
