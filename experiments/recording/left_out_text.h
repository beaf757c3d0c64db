// What of a recording cannot be had, in sentences for people.
#pragma once

#include <string>
#include <vector>

#include "experiments/mcap/reader.h"

namespace romano::experiments {

[[nodiscard]] std::vector<std::string> sentences_about(const mcap::Reader& reader);

/// "2026-11-25 20:15:00.250 UTC"
[[nodiscard]] std::string utc_text(mcap::Timestamp time);

}  // namespace romano::experiments
