// The text trace: what people read on stderr. (The logs of the cluster are something else.)
#pragma once

#include <string>

namespace romano::daemon {

/// `level` as in --log-level. From here on spdlog's default logger writes to stderr.
void start_trace(const std::string& level);

}  // namespace romano::daemon
