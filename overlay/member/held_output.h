// Datagrams to clients that wait until the log is safe up to their Send::after (design section 3,
// "Replication"). They leave in the order of these positions, and as they came within one: a
// client's later datagrams never have a lower position (broker::Send), so that its order is kept.
//
// Bounded by octets; beyond that new ones are dropped, as a network may do: clients ask again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "broker/core/actions.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"

namespace romano::overlay {

class HeldOutput {
public:
    void hold(const broker::Send& send, Bytes octets);
    /// Moves all that may leave now to `out`.
    void release(broker::Seq safe, broker::Actions& out);
    /// Drops what waits to leave from that address.
    void drop(const Endpoint& via);
    void clear();

    [[nodiscard]] std::set<Endpoint> addresses() const;
    [[nodiscard]] bool empty() const { return waiting_.empty(); }
    [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

private:
    struct Datagram {
        Endpoint via;
        broker::ClientAddress to;
        std::vector<std::uint8_t> octets;
    };

    std::multimap<broker::Seq, Datagram> waiting_;
    std::size_t octets_ = 0;
    std::uint64_t dropped_ = 0;
};

}  // namespace romano::overlay
