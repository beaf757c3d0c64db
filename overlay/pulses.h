// When a broker says that its process lives although its core is late with the next beacon.
//
// A core that works to the limit, or waits for a processor that others have, is late by several
// beacon times; replacing it would cost its robots more than waiting. So another thread of the
// process goes on for it, for half a detection time and no longer: a core that hangs is replaced
// after one and a half, a process that is stopped or gone after one, as ever.
#pragma once

#include "romano/base/time.h"

namespace romano::overlay {

class Pulses {
public:
    Pulses(Duration beacon_every, Duration detection_timeout)
        : every_(beacon_every), patience_(detection_timeout / 2) {}

    void on_beacon(Instant now) {
        next_ = now + every_ + every_ / 2;
        last_ = now + every_ + patience_;
    }
    /// After the last beacon nothing follows.
    void end() { next_ = never; }
    /// A pulse is due now.
    [[nodiscard]] bool take_due(Instant now) {
        if (now < next_) return false;
        const bool is_too_late = now > last_;
        next_ = is_too_late || now + every_ > last_ ? never : now + every_;
        return !is_too_late;
    }
    /// Nothing is due before; `never`: not before the next beacon.
    [[nodiscard]] Instant next() const { return next_; }

private:
    Duration every_;
    Duration patience_;
    Instant next_ = never;
    Instant last_{};
};

}  // namespace romano::overlay
