// How often an address without a session is heeded: at most so many times a second each, so that
// two brokers cannot echo DISCONNECT for ever and nobody is flooded in another's name (G8); and all
// ports of one IP address together more often, so that a swarm behind a NAT may come at once, and
// no host takes all of the broker by sending from one port after the other.
//
// Fixed tables: two addresses may share a place, and are then limited together.
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
    StrangerLimit(std::size_t per_second, std::size_t per_second_of_host)
        : per_second_(per_second), per_second_of_host_(per_second_of_host) {}

    /// True when this address may be heeded once more.
    bool allows(const Endpoint& address, Instant now) {
        if (now >= until_) {
            answered_.fill(0);
            answered_hosts_.fill(0);
            until_ = now + std::chrono::seconds{1};
        }
        Endpoint host = address;
        host.port = 0;
        std::uint32_t& of_address = answered_[address.hash() % answered_.size()];
        std::uint32_t& of_host = answered_hosts_[host.hash() % answered_hosts_.size()];
        if (of_address >= per_second_ || of_host >= per_second_of_host_) return false;
        ++of_address;
        ++of_host;
        return true;
    }

private:
    std::size_t per_second_;
    std::size_t per_second_of_host_;
    Instant until_{};
    std::array<std::uint32_t, 512> answered_{};
    std::array<std::uint32_t, 512> answered_hosts_{};
};

}  // namespace romano::broker
