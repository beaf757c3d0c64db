// A file with rights, for brokers and for `romano rights check`.
#pragma once

#include <string>

#include "broker/rights/rules.h"
#include "romano/base/result.h"

namespace romano::daemon {

/// The rules, or a sentence without the file's name: "line 7: 'x' begins no line ...".
[[nodiscard]] Result<rights::Rules, std::string> read_rights_file(const std::string& file);

}  // namespace romano::daemon
