// Why the broker does not start: one sentence that names the setting, its value and what is
// allowed. main() prints it and ends with exit code 2; nothing has been started by then.
#pragma once

#include <stdexcept>

namespace romano::daemon {

class Refusal : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

}  // namespace romano::daemon
