// Octets that nobody can guess, of the system's generator.
#pragma once

#include "romano/base/bytes.h"

namespace romano::keys {

/// Throws KeyError when the system has none.
void fill_at_random(MutableBytes octets);

}  // namespace romano::keys
