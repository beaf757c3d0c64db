// AES-128 (FIPS 197), one block, the direction that CCM needs.
//
// The round keys are made anew for each block: a robot keeps 16 octets of a key instead of 176. The
// table of 256 octets leaks nothing by time where memory has no cache, as on a Cortex-M3.
#pragma once

#include <array>
#include <cstdint>

#include "romano/protection/keys.h"

namespace romano::protection {

using Block = std::array<std::uint8_t, 16>;

void encrypt(const Key& key, Block& block);

}  // namespace romano::protection
