// Log events as Protobuf: broker/core/log_event.h.
#pragma once

#include <optional>

#include "broker/core/log_event.h"
#include "overlay/dds/log_event.pb.h"

namespace romano::overlay::proto {

void to_proto(const broker::LogEventPtr& in, LogEvent& out);  // in is not null
[[nodiscard]] std::optional<broker::LogEvent> from_proto(const LogEvent& in);

}  // namespace romano::overlay::proto
