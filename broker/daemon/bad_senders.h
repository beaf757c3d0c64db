// Says once of each sender that its datagrams are no MQTT-SN; after that they are only counted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_set>

#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"

namespace romano::daemon {

class BadSenders {
public:
    /// After each datagram; `malformed_total` of the core tells whether to look at it.
    void look(std::uint64_t malformed_total, const Endpoint& from, Bytes datagram) {
        if (malformed_total == seen_) return;
        seen_ = malformed_total;
        note(from, datagram);
    }

private:
    static constexpr std::size_t most = 1000;  // a flood from new ports must not fill the trace

    void note(const Endpoint& from, Bytes datagram);

    std::uint64_t seen_ = 0;
    std::unordered_set<Endpoint, EndpointHash> named_;
};

}  // namespace romano::daemon
