// What a broker core wants done, in order: the caller owns the buffer, drains it and reuses it.
//
// Octets to send lie in one arena, so that an action is small and draining allocates nothing. It is
// bounded: a long message to thousands of clients, each under a topic id of its own, would take
// gigabytes. What goes beyond is dropped and counted, as it would be where a socket's buffer is
// full.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "broker/core/client_address.h"
#include "broker/core/log_event.h"
#include "broker/core/log_position.h"
#include "romano/base/bytes.h"

namespace romano::broker {

/// Send a datagram from `via` to `to` once the own log is safe up to `after` (0: at once). A Send
/// that must not overtake an earlier one to the same client has an `after` that is not lower.
struct Send {
    Endpoint via;
    ClientAddress to;  // a wireless node id means: the octets are already encapsulated
    Seq after = 0;
    std::uint32_t offset = 0;
    std::uint32_t size = 0;
};

/// Send a datagram to the discovery group of `via`'s address family (MQTT-SN 1.2 section 6.1).
struct Multicast {
    std::uint8_t radius = 0;
    std::uint32_t offset = 0;
    std::uint32_t size = 0;
};

/// Append to the own log. Sequence numbers count up without gaps.
struct Append {
    Seq seq = 0;
    LogEventPtr event;
};

/// A QoS 0 publish of an own client: for peers that have a matching subscriber.
struct Forward {
    MessagePtr message;
};

/// A client of this broker published on one of BrokerOptions::observed_topics: for what the owner
/// runs beside the broker.
struct Observation {
    ClientId publisher;
    std::string topic;
    std::vector<std::uint8_t> payload;
};
struct Observed {
    std::unique_ptr<Observation> what;
};

/// Beside what waits in the session that the owner reads (BrokerOptions::read_by_owner): a message
/// of QoS 0 for it, which never waits, or one with an origin, wherever in the cluster it came in.
struct ForOwner {
    MessagePtr message;
};

/// A warning for people (notes.h).
struct Note {
    std::unique_ptr<std::string> text;
};

using Action = std::variant<Send, Multicast, Append, Forward, Observed, ForOwner, Note>;

class Actions {
public:
    [[nodiscard]] std::span<const Action> list() const { return list_; }
    [[nodiscard]] std::span<Action> list() { return list_; }
    [[nodiscard]] bool empty() const { return list_.empty(); }
    [[nodiscard]] Bytes octets(const Send& send) const {
        return Bytes{arena_}.subspan(send.offset, send.size);
    }
    [[nodiscard]] Bytes octets(const Multicast& send) const {
        return Bytes{arena_}.subspan(send.offset, send.size);
    }

    /// Keeps the storage, but not that of a rare huge fan-out.
    void clear() {
        list_.clear();
        arena_.clear();
        if (arena_.capacity() > most_octets_kept) arena_ = {};
    }

    [[nodiscard]] std::size_t octets_held() const { return arena_.size(); }
    /// Nothing more can be sent until it is drained.
    [[nodiscard]] bool is_full() const { return arena_.size() >= most_octets_held; }

    template <typename A>
    A& push(A action) {
        return std::get<A>(list_.emplace_back(std::move(action)));
    }

    /// Sends a copy of these octets.
    template <typename A>
    void push(A action, Bytes octets) {
        std::ranges::copy(octets, reserve(octets.size()).begin());
        action.offset = commit(octets.size());
        action.size = static_cast<std::uint32_t>(octets.size());
        push(std::move(action));
    }

    /// Room for up to `most` octets at the arena's end; commit() keeps the first of them.
    [[nodiscard]] MutableBytes reserve(std::size_t most) {
        reserved_at_ = arena_.size();
        arena_.resize(reserved_at_ + most);
        return MutableBytes{arena_}.subspan(reserved_at_);
    }
    /// Returns the offset of the kept octets.
    std::uint32_t commit(std::size_t kept) {
        arena_.resize(reserved_at_ + kept);
        return static_cast<std::uint32_t>(reserved_at_);
    }

private:
    static constexpr std::size_t most_octets_held = std::size_t{64} << 20U;
    static constexpr std::size_t most_octets_kept = std::size_t{4} << 20U;

    std::vector<Action> list_;
    std::vector<std::uint8_t> arena_;
    std::size_t reserved_at_ = 0;
};

}  // namespace romano::broker
