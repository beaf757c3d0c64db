// The one timer of a core: wakes the shell at next_wakeup().
//
// A wake-up that turns out too early is harmless to a core, so a deadline that moves back leaves
// the timer as it is: no system call for each datagram.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <utility>

#include "broker/net/latency_histogram.h"
#include "broker/net/turn_clock.h"
#include "romano/base/time.h"

namespace romano::net {

class CoreTimer {
public:
    /// `on_wakeup` carries the tick out and calls arm() again.
    CoreTimer(boost::asio::io_context& io, std::function<void()> on_wakeup);

    /// Wakes at `deadline` or earlier; `never` is fine.
    void arm(Instant deadline);
    void stop();

    /// How much later than asked for it woke.
    [[nodiscard]] const LatencyHistogram& delays() const { return delays_; }

private:
    void wait();

    TurnClock& turns_;
    boost::asio::steady_timer timer_;
    std::function<void()> on_wakeup_;
    Instant armed_for_ = never;
    LatencyHistogram delays_;
};

}  // namespace romano::net
