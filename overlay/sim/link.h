// What a network does to what is sent over it, and who cannot hear whom.
#pragma once

#include <chrono>
#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "romano/base/random.h"
#include "romano/base/time.h"

namespace romano::sim {

/// A place in a network: a robot, or a broker's machine. Stays the same when a process restarts.
enum class Node : std::uint32_t {};

struct LinkQuality {
    Duration delay_min{std::chrono::microseconds{50}};
    Duration delay_max{std::chrono::microseconds{300}};
    bool overtaking = false;  // a datagram may come before one that was sent earlier
    std::uint32_t loss_ppm = 0;
    std::uint32_t duplication_ppm = 0;
    std::uint32_t late_copy_ppm = 0;  // clients' links, where no receiver is misled by it

    [[nodiscard]] Duration delay(Random& random) const {
        return random.between(delay_min, delay_max + Duration{1});
    }
};

/// Cuts between nodes, each for one direction, with the time at which they were made.
class Cuts {
public:
    void cut(Node from, Node to, Instant now) { since_.try_emplace({from, to}, now); }
    void cut_both(Node a, Node b, Instant now) {
        cut(a, b, now);
        cut(b, a, now);
    }
    void join(Node from, Node to) { since_.erase({from, to}); }
    void join_all() { since_.clear(); }

    [[nodiscard]] bool is_cut(Node from, Node to) const { return since_.contains({from, to}); }
    [[nodiscard]] std::optional<Instant> cut_since(Node from, Node to) const {
        const auto found = since_.find({from, to});
        if (found == since_.end()) return std::nullopt;
        return found->second;
    }
    [[nodiscard]] bool empty() const { return since_.empty(); }

private:
    std::map<std::pair<Node, Node>, Instant> since_;
};

}  // namespace romano::sim
