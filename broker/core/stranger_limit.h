// How often an address without a session is heeded: at most so many times a second each, so that
// two brokers cannot echo DISCONNECT for ever and nobody is flooded in another's name (G8).
//
// A fixed table: two addresses may share a place, and are then limited together.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "romano/base/endpoint.h"
#include "romano/base/time.h"

namespace romano::broker {

class StrangerLimit {
public:
    explicit StrangerLimit(std::size_t per_second) : per_second_(per_second) {}

    /// True when this address may be heeded once more.
    bool allows(const Endpoint& address, Instant now) {
        if (now >= until_) {
            answered_.fill(0);
            until_ = now + std::chrono::seconds{1};
        }
        std::uint32_t& answered = answered_[address.hash() % answered_.size()];
        if (answered >= per_second_) return false;
        ++answered;
        return true;
    }

private:
    std::size_t per_second_;
    Instant until_{};
    std::array<std::uint32_t, 512> answered_{};
};

}  // namespace romano::broker
