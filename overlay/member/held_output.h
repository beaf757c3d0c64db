// Datagrams to clients that wait until the log is safe up to their Send::after (design section 3,
// "Replication"). They leave in the order of these positions, and as they came within one: a
// client's later datagrams never have a lower position (broker::Send), so that its order is kept.
//
// Bounded by octets; beyond that new ones are dropped, as a network may do: clients ask again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
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
    /// Moves all that may leave now to `out`; an address that is not bound yet keeps its own.
    template <typename MayLeave>
    void release(broker::Seq safe, MayLeave&& may_leave, broker::Actions& out) {
        for (auto next = waiting_.begin(); next != waiting_.end() && next->first <= safe;) {
            next = may_leave(next->second.via) ? send(next, out) : std::next(next);
        }
    }
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

    using Waiting = std::multimap<broker::Seq, Datagram>;

    Waiting::iterator send(Waiting::iterator datagram, broker::Actions& out);

    Waiting waiting_;
    std::size_t octets_ = 0;
    std::uint64_t dropped_ = 0;
};

}  // namespace romano::overlay
