// What brokers know each other by, from a broker's --keys folder.
#pragma once

#include <optional>
#include <string>

#include "overlay/dds/domain.h"

namespace romano::daemon {

/// Throws Refusal when DDS would not take them.
[[nodiscard]] std::optional<dds::Papers> peer_papers(const std::string& folder);

}  // namespace romano::daemon
