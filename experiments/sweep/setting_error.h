// What a person asked for is not possible: one sentence that names the setting, the value and what
// is allowed. Nothing has started by then.
#pragma once

#include <stdexcept>

namespace romano::experiments {

struct SettingError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

}  // namespace romano::experiments
