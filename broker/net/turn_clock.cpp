#include "broker/net/turn_clock.h"

#include <algorithm>
#include <utility>

namespace romano::net {

void TurnClock::end(Instant time) {
    if (!has_begun()) return;
    const Duration took = time - std::exchange(began_, never);
    if (window_began_ == Instant::min()) window_began_ = time;
    const Duration since = time - window_began_;
    if (since >= window) {
        before_ = since < 2 * window ? longest_ : Duration{0};
        longest_ = Duration{0};
        window_began_ = time;
    }
    longest_ = std::max(longest_, took);
}

Duration TurnClock::longest(Instant time) const {
    if (window_began_ == Instant::min()) return Duration{0};
    const Duration since = time - window_began_;
    if (since >= 2 * window) return Duration{0};
    return since >= window ? longest_ : std::max(longest_, before_);
}

void run_in_turns(boost::asio::io_context& io) {
    TurnClock& clock = TurnClock::of(io);
    while (io.run_one() > 0) {
        if (clock.has_begun()) clock.end(now());
    }
}

}  // namespace romano::net
