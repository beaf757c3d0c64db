// Datagrams to clients that wait until the log is safe up to their Send::after. They leave in the
// order of these positions, and as they came within one: a client's later datagrams never have a
// lower position (broker::Send), so that its order is kept. Those of an address that is not served
// here yet wait for that, and so does what the same client is sent from another one: it may have
// answered what waits already.
//
// So many leave in one turn at most (I8); whatever is sent before the others have left follows
// them.
//
// Bounded by octets; beyond that new ones are dropped, as a network may do: clients ask again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <set>
#include <unordered_set>
#include <vector>

#include "broker/core/actions.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"

namespace romano::cluster {

class HeldOutput {
public:
    void hold(const broker::Send& send, Bytes octets);
    /// Something waits for its address, perhaps: whatever is for this client waits as well.
    void detain(const broker::ClientAddress& client) { detained_.insert(client); }
    [[nodiscard]] bool detains(const broker::ClientAddress& client) const {
        return detained_.contains(client);
    }
    /// What is to become of a datagram of that address, once its position is safe.
    enum class Fate : std::uint8_t { leaves, waits, is_dropped };

    /// Moves what may leave now to `out`, so many at most; `fate_of(via)` says what may.
    template <typename FateOf>
    void release(broker::Seq safe, FateOf&& fate_of, std::size_t most, broker::Actions& out) {
        detained_.clear();
        auto next = waiting_.begin();
        while (next != waiting_.end() && next->first <= safe && most > 0) {
            const broker::ClientAddress& client = next->second.to;
            Fate fate = fate_of(next->second.via);
            if (fate == Fate::leaves && detains(client)) fate = Fate::waits;
            if (fate == Fate::waits) detain(client);
            if (fate == Fate::leaves) {
                send(next->second, out);
                --most;
            }
            next = fate == Fate::waits ? std::next(next) : erase(next);
        }
        is_behind_ = next != waiting_.end() && next->first <= safe;
    }
    /// More may leave than the last release() let go.
    [[nodiscard]] bool is_behind() const { return is_behind_; }
    /// Some would leave before what is said now, were they released.
    [[nodiscard]] bool holds_any_through(broker::Seq safe) const {
        return !waiting_.empty() && waiting_.begin()->first <= safe;
    }
    void clear();

    [[nodiscard]] std::set<Endpoint> addresses() const;
    [[nodiscard]] bool empty() const { return waiting_.empty(); }
    [[nodiscard]] std::size_t size() const { return waiting_.size(); }
    [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

private:
    struct Datagram {
        Endpoint via;
        broker::ClientAddress to;
        std::vector<std::uint8_t> octets;
    };

    using Waiting = std::multimap<broker::Seq, Datagram>;

    static void send(const Datagram& datagram, broker::Actions& out);
    Waiting::iterator erase(Waiting::iterator datagram);

    Waiting waiting_;
    std::unordered_set<broker::ClientAddress, broker::ClientAddressHash> detained_;
    std::size_t octets_ = 0;
    std::uint64_t dropped_ = 0;
    bool is_behind_ = false;
};

}  // namespace romano::cluster
