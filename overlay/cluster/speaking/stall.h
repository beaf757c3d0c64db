// A member that stood still, paused or starved, and listens before it says anything (design
// section 3, "After a stall").
//
// What it reads first may have waited since before the others replaced it, and after a long stall
// their transport must find it again. So a beacon from the end of the stall tells; or, when all
// stood still, that beacons come steadily. Whoever stands still again meanwhile listens anew: its
// patience is counted in its own beats.
#pragma once

#include <algorithm>
#include <cstdint>

#include "overlay/cluster/speaking/listening.h"
#include "romano/base/time.h"

namespace romano::cluster {

class Stall {
public:
    explicit Stall(Duration beacon_every) : beacon_every_(beacon_every) {}

    [[nodiscard]] bool is_on() const { return is_on_; }
    /// Nothing is said before, but pulses.
    [[nodiscard]] Instant listen_until() const { return listen_until_; }
    [[nodiscard]] Instant next_wakeup() const { return std::min(listen_until_, next_pulse_); }
    /// So late that it may have been replaced, or is about to be. `next_beat`: when it was to wake
    /// up; none while it listens already.
    [[nodiscard]] bool is_noticed(Instant now, Instant next_beat, Duration detection_time) const;
    /// It begins, or begins anew. Returns for how long the member was away.
    Duration begin(Instant now, Instant next_beat, Duration detection_time);
    /// A pulse is due: peers wait for one that listens, but not for one that stands still again and
    /// again.
    [[nodiscard]] bool take_pulse(Instant now);
    /// At `listen_until()`: whether it has heard enough, or waited long enough; if not, it listens
    /// for another beacon time. `is_alone`: there is no peer that could say anything.
    [[nodiscard]] bool is_over(Instant now, Listening& heard, bool is_alone);
    /// It has waited long enough, but a member takes it for dead: that one shall hear beacons, and
    /// say whether it has replaced us, before a client hears anything.
    [[nodiscard]] bool is_calling() const { return is_on_ && is_calling_; }
    void end() { is_on_ = false; }

private:
    Duration beacon_every_;
    bool is_on_ = false;
    Instant listen_until_;
    Instant next_pulse_ = never;
    Instant last_pulse_;           // at most; of several stalls in a row
    std::int64_t beats_left_ = 0;  // own ones; then nobody is there who could say what happened
    bool is_calling_ = false;
    std::int64_t calls_left_ = 0;
    int heard_in_a_row_ = 0;  // beacon times in which peers were heard
};

}  // namespace romano::cluster
