// The broker core's limits as settings: one row each, for the command line, the configuration file
// and the check.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string>

#include "broker/core/limits.h"

namespace romano::daemon {

struct LimitSetting {
    const char* key;  // --key, and key of the file
    std::size_t broker::Limits::*limit;
    std::size_t low;
    std::size_t high;
    const char* help;
};

[[nodiscard]] std::span<const LimitSetting> limit_settings();

/// Texts by key, as the core has them when nothing is said.
[[nodiscard]] std::map<std::string, std::string> default_limit_texts();

}  // namespace romano::daemon
