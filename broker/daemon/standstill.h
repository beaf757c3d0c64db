// Says when this broker came late to its peers, and why: its own work took the time, or other
// programs had the processor. A broker that stands still for the detection timeout is replaced.
#pragma once

#include "romano/base/time.h"

namespace romano::daemon {

class Standstill {
public:
    explicit Standstill(Duration detection_timeout) : detection_timeout_(detection_timeout) {}

    /// At each wake-up of the core, which was due at `due`; Instant::min(): at once. `worked`: the
    /// processor time of the thread so far.
    void look(Instant now, Instant due, Duration worked);

private:
    static constexpr Duration said_again_after = std::chrono::seconds{1};

    Duration detection_timeout_;
    Instant seen_at_ = Instant::min();
    Duration worked_before_{0};
    Instant quiet_until_ = Instant::min();
};

/// The processor time that the calling thread has taken so far.
[[nodiscard]] Duration thread_processor_time();

}  // namespace romano::daemon
