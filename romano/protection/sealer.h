// Seals packets under one key, each with its own number. Several sealers, with different keys,
// share a sender's reserve.
#pragma once

#include <cstddef>
#include <cstdint>

#include "romano/base/bytes.h"
#include "romano/protection/keys.h"
#include "romano/protection/packet.h"
#include "romano/protection/refusal.h"
#include "romano/protection/reserve.h"

namespace romano::protection {

class Sealer {
public:
    /// The key outlives it. Begins above all numbers that were ever used: a sealer for the same
    /// key, long gone, used others.
    Sealer(const Key& key, const SenderId& self, Reserve& reserve)
        : key_(key), self_(self), reserve_(reserve), next_(reserve.unused()) {}

    /// The packet's size; 0, and counted, when it is refused. `message` may lie in `out`.
    std::size_t seal(RunId run, Bytes message, MutableBytes out, Refusals& refusals);

    /// The number of the next packet.
    [[nodiscard]] std::uint32_t next() const { return next_; }

    /// The rest of the block stays unused.
    void skip_block();

private:
    const Key& key_;
    SenderId self_;
    Reserve& reserve_;
    std::uint32_t next_;
};

}  // namespace romano::protection
