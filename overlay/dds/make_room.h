// Tables of peers are bounded, and the names that a transport hears in its life are not.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>

namespace romano::dds {

inline constexpr auto forgotten_after = std::chrono::minutes{1};

/// Whether one more has a place among `most`: in a full table that of who was silent longest, if it
/// was for over a minute. `peers` is a map to what has a `heard_at`.
template <typename Peers>
[[nodiscard]] bool make_room(Peers& peers, std::size_t most,
                             std::chrono::steady_clock::time_point now) {
    if (peers.size() < most) return true;
    const auto silent = std::ranges::min_element(
        peers, {}, [](const auto& entry) { return entry.second.heard_at; });
    if (now - silent->second.heard_at <= forgotten_after) return false;
    peers.erase(silent);
    return true;
}

}  // namespace romano::dds
