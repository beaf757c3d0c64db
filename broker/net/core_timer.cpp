#include "broker/net/core_timer.h"

#include <utility>

#include "broker/net/clock.h"

namespace romano::net {

CoreTimer::CoreTimer(boost::asio::io_context& io, std::function<void()> on_wakeup)
    : turns_(TurnClock::of(io)), timer_(io), on_wakeup_(std::move(on_wakeup)) {}

void CoreTimer::arm(Instant deadline) {
    if (deadline >= armed_for_) return;
    armed_for_ = deadline;
    wait();
}

void CoreTimer::stop() {
    armed_for_ = never;
    timer_.cancel();
}

void CoreTimer::wait() {
    timer_.expires_at(to_steady_clock(armed_for_));
    timer_.async_wait([this](const boost::system::error_code& error) {
        if (error || armed_for_ == never) return;
        // A wait that was replaced just as it ended may bring an old wake-up.
        const Instant woken = now();
        if (woken < armed_for_) return wait();
        turns_.begin(woken);
        const Instant deadline = std::exchange(armed_for_, never);
        const bool at_once = deadline == Instant::min();
        delays_.add(at_once ? Duration{0} : woken - deadline, 1);
        on_wakeup_();
    });
}

}  // namespace romano::net
