// What handshakes of DTLS took of the heap goes back to the system when they are over: a handshake
// has 70 KB, between blocks that stay, and a heap gives back of itself what lies at its end alone.
//
// Not while handshakes go on, and once in ten seconds at most: it is a turn of 1 ms, and of 4 where
// 256 handshakes, as many as there may be, lie between the blocks of 10,000 sessions.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

#include "romano/base/time.h"

namespace romano::daemon {

/// All that is free, by malloc_trim(3).
void give_free_memory_back();

class HandshakeMemory {
public:
    static constexpr auto at_most_every = std::chrono::seconds{10};

    explicit HandshakeMemory(std::function<void()> give_back = give_free_memory_back);

    /// About once a second: how many handshakes go on, and how many have ended so far.
    void on_time(Instant now, std::size_t going_on, std::uint64_t ended);

private:
    std::function<void()> give_back_;
    std::uint64_t ended_ = 0;  // when memory was given back last
    std::optional<Instant> last_;
};

}  // namespace romano::daemon
