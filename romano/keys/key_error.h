// Why a key cannot be used: one sentence that names the file and says what to do.
#pragma once

#include <stdexcept>

namespace romano::keys {

class KeyError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

}  // namespace romano::keys
