// Why the broker does not start: one sentence that names the setting, its value and what is
// allowed. main() prints it and ends with exit code 2; nothing has been started by then.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace romano::daemon {

class Refusal : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// "--option 'value': why"
[[noreturn]] inline void refuse_option(std::string_view option, std::string_view value,
                                       std::string_view why) {
    throw Refusal("--" + std::string(option) + " '" + std::string(value) +
                  "': " + std::string(why));
}

}  // namespace romano::daemon
