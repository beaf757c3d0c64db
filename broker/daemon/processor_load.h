// How much of a processor's core this process had of late: a part of its load, for people.
#pragma once

#include <cstdint>
#include <deque>

#include "romano/base/time.h"

namespace romano::daemon {

class ProcessorLoad {
public:
    /// percent() looks back so far, or to the first reading.
    static constexpr Duration window = std::chrono::seconds{5};

    /// `used`: the processor time of the process so far. About once a second; what comes sooner
    /// after the last reading is passed over.
    void on_reading(Instant now, Duration used);
    /// Of one core, rounded; a process with several threads can have more than 100.
    [[nodiscard]] std::uint32_t percent() const;

private:
    static constexpr Duration least_apart = std::chrono::milliseconds{500};

    struct Reading {
        Instant at;
        Duration used;
    };
    std::deque<Reading> readings_;  // back to one that is as old as the window
};

/// The processor time that all threads of this process have taken so far.
[[nodiscard]] Duration process_processor_time();

}  // namespace romano::daemon
