// How often, and for how long, the machine itself stood still while something was measured.
//
// A thread a core, above all other programs, sleeps for a millisecond at a time and looks how late
// it wakes. No program under test keeps it waiting: what is late there is the machine. The host of
// a virtual one takes its processors away, and `steal` in /proc/stat need not say so.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "romano/base/time.h"

namespace romano::bench {

/// Late wake-ups of one thread: any thread may look while that one counts.
class LateWakeUps {
public:
    /// Less is what a busy kernel does.
    static constexpr Duration counted_from = std::chrono::milliseconds{4};

    void on_wake_up(Duration late);
    [[nodiscard]] std::uint64_t count() const { return count_; }
    [[nodiscard]] Duration longest() const { return longest_.load(); }

private:
    std::atomic<std::uint64_t> count_{0};
    std::atomic<Duration> longest_{Duration{}};
};

class MachineStalls {
public:
    struct Seen {
        std::uint64_t count = 0;  // of four milliseconds or longer, on the core that had most
        Duration longest{};       // of these
    };

    /// Looks from now on, as far as this user may have threads above all others (SCHED_FIFO).
    MachineStalls();
    MachineStalls(const MachineStalls&) = delete;
    MachineStalls& operator=(const MachineStalls&) = delete;
    ~MachineStalls() = default;

    /// So far. Nothing: this user may not look.
    [[nodiscard]] std::optional<Seen> seen() const;

private:
    struct Core {
        LateWakeUps late;
        std::jthread thread;  // ends before the rest of it
    };
    std::vector<std::unique_ptr<Core>> cores_;
};

/// One sentence.
[[nodiscard]] std::string text_of(const std::optional<MachineStalls::Seen>& seen);

}  // namespace romano::bench
