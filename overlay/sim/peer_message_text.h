// What a message between brokers says, in a line, for the trace.
#pragma once

#include <string>

#include "overlay/cluster/messages.h"

namespace romano::sim {

[[nodiscard]] std::string to_text(const cluster::ClusterMessage& message);

}  // namespace romano::sim
