#include "overlay/cluster/speaking/stall.h"

#include <algorithm>

namespace romano::cluster {
namespace {

constexpr int most_detection_times_waited = 20;  // for peers
constexpr int beacon_times_heard = 5;            // one after the other: they live, and we hear them

}  // namespace

bool Stall::is_noticed(Instant now, Instant next_beat, Duration detection_time) const {
    if (is_on_) return now >= listen_until_ + 2 * beacon_every_;
    // Peers that missed our beat replace us a beacon time before the detection time at the soonest.
    // Of what we say just before, half a beacon time earlier, their acknowledgement is here first.
    return next_beat != Instant::min() &&
           now >= next_beat + std::max(detection_time - 5 * beacon_every_ / 2, 2 * beacon_every_);
}

Duration Stall::begin(Instant now, Instant next_beat, Duration detection_time) {
    const Duration away = now - (is_on_ ? listen_until_ : next_beat);
    const std::int64_t beats =
        std::min(away, most_detection_times_waited * detection_time) / beacon_every_;
    beats_left_ = is_on_ ? std::max(beats_left_, beats) : beats;
    if (!is_on_) last_pulse_ = now + detection_time;
    is_on_ = true;
    next_pulse_ = now;
    listen_until_ = now + 3 * beacon_every_;
    is_calling_ = false;
    calls_left_ = detection_time / beacon_every_;
    heard_in_a_row_ = 0;
    return away;
}

bool Stall::take_pulse(Instant now) {
    if (now < next_pulse_) return false;
    next_pulse_ = now < last_pulse_ ? now + beacon_every_ : never;
    return now < last_pulse_;
}

bool Stall::is_over(Instant now, Listening& heard, bool is_alone) {
    heard_in_a_row_ = heard.take_heard() ? heard_in_a_row_ + 1 : 0;
    const bool knows =
        !heard.is_doubted(now) && (heard.is_up_to_date() || heard_in_a_row_ >= beacon_times_heard);
    if (knows || is_alone) return true;
    if (beats_left_-- <= 0) {
        if (!heard.is_doubted(now) || calls_left_-- <= 0) return true;
        is_calling_ = true;
    }
    listen_until_ = now + beacon_every_;
    return false;
}

}  // namespace romano::cluster
