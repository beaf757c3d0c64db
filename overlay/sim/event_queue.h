// Virtual time: what happens, in the order of (time, sequence). Nothing else moves the clock.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "romano/base/time.h"

namespace romano::sim {

class EventQueue {
public:
    using Event = std::function<void()>;

    [[nodiscard]] Instant now() const { return now_; }

    /// Events of one time happen in the order in which they were asked for. A time in the past
    /// means now.
    void at(Instant when, Event event);
    void after(Duration delay, Event event) { at(now_ + delay, std::move(event)); }

    /// When something happens next; or never.
    [[nodiscard]] Instant next() const { return heap_.empty() ? never : heap_.front().when; }
    /// The clock then stands at `end`.
    void run_until(Instant end);
    void run_for(Duration duration) { run_until(now_ + duration); }

private:
    struct Entry {
        Instant when;
        std::uint64_t sequence;
        std::size_t slot;  // in events_: the heap moves small things only
    };
    static bool later(const Entry& a, const Entry& b);

    static constexpr std::uint64_t livelock = 1'000'000;

    Instant now_{};
    std::uint64_t at_this_time_ = 0;
    std::uint64_t next_sequence_ = 0;
    std::vector<Entry> heap_;
    std::vector<Event> events_;
    std::vector<std::size_t> free_slots_;
};

}  // namespace romano::sim
