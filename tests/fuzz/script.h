#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "romano/base/bytes.h"

namespace romano::fuzz {

/// Takes a fuzzer's input apart; at its end it gives zeros.
class Script {
public:
    explicit Script(Bytes octets) : octets_(octets) {}
    [[nodiscard]] bool is_over() const { return octets_.empty(); }
    std::uint8_t octet() {
        if (octets_.empty()) return 0;
        const std::uint8_t first = octets_[0];
        octets_ = octets_.subspan(1);
        return first;
    }
    Bytes octets(std::size_t wanted) {
        const Bytes taken = octets_.first(std::min(wanted, octets_.size()));
        octets_ = octets_.subspan(taken.size());
        return taken;
    }
    /// As many as the next octet says.
    Bytes octets() { return octets(octet()); }

private:
    Bytes octets_;
};

}  // namespace romano::fuzz
