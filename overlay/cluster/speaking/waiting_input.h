// Clients' datagrams that cannot be answered yet: before the first view, without a lease, and while
// sessions of their service address are on their way here. So many are served in one turn at most
// (I8). A session that leaves meanwhile leaves them behind: its client said them before it spoke
// elsewhere, and an exchange that has ended there must not be heard again (P3).
//
// Bounded by octets; beyond that new ones are dropped, as a network may do: clients ask again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"

namespace romano::cluster {

class WaitingInput {
public:
    struct Datagram {
        Endpoint via;
        Endpoint from;
        std::vector<std::uint8_t> octets;
        bool is_new = false;     // the cluster was not asked yet whose client this is
        bool was_homed = false;  // its session was here when it came
    };

    void hold(const Endpoint& via, const Endpoint& from, Bytes octets, bool is_new,
              bool was_homed = false) {
        if (octets_ + octets.size() + overhead > octets_most) {
            ++dropped_;
            return;
        }
        octets_ += octets.size() + overhead;
        waiting_.push_back({via, from, {octets.begin(), octets.end()}, is_new, was_homed});
        ++clients_[from];
    }

    /// Those that need not wait any more, so many at most, in the order in which they came.
    template <typename MustWait>
    [[nodiscard]] std::vector<Datagram> take_unless(MustWait&& must_wait, std::size_t most) {
        is_behind_ = false;
        return remove_if([&](const Datagram& datagram) {
            if (is_behind_ || must_wait(datagram)) return false;
            is_behind_ = most == 0;
            if (!is_behind_) --most;
            return !is_behind_;
        });
    }
    /// These wait on, as they came, before all that came since.
    void put_back(std::vector<Datagram> taken) {
        for (const Datagram& datagram : taken) {
            octets_ += datagram.octets.size() + overhead;
            ++clients_[datagram.from];
        }
        waiting_.insert(waiting_.begin(), std::make_move_iterator(taken.begin()),
                        std::make_move_iterator(taken.end()));
    }
    /// More could be served than the last take_unless() took.
    [[nodiscard]] bool is_behind() const { return is_behind_; }

    /// Something of that client waits, or was not served yet: what comes now comes after it.
    [[nodiscard]] bool holds(const Endpoint& client) const { return clients_.contains(client); }

    /// All that came by that address: clients ask again, and somebody else answers there now.
    void drop(const Endpoint& via) {
        (void)remove_if([&](const Datagram& datagram) { return datagram.via == via; });
        is_behind_ = is_behind_ && !waiting_.empty();
    }
    void clear() {
        waiting_.clear();
        clients_.clear();
        octets_ = 0;
        is_behind_ = false;
    }
    [[nodiscard]] bool empty() const { return waiting_.empty(); }
    [[nodiscard]] std::size_t size() const { return waiting_.size(); }
    [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

private:
    template <typename IsRemoved>
    std::vector<Datagram> remove_if(IsRemoved&& is_removed) {
        std::vector<Datagram> removed;
        std::erase_if(waiting_, [&](Datagram& datagram) {
            if (!is_removed(datagram)) return false;
            octets_ -= datagram.octets.size() + overhead;
            const auto client = clients_.find(datagram.from);
            if (--client->second == 0) clients_.erase(client);
            removed.push_back(std::move(datagram));
            return true;
        });
        return removed;
    }

    static constexpr std::size_t octets_most = 8U << 20U;
    static constexpr std::size_t overhead = 128;  // of one datagram in the queue

    std::deque<Datagram> waiting_;
    std::map<Endpoint, std::size_t> clients_;  // how many of each wait
    std::size_t octets_ = 0;
    std::uint64_t dropped_ = 0;
    bool is_behind_ = false;
};

}  // namespace romano::cluster
