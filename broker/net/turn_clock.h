// How long the one thread of an io_context was busy at a stretch, while everything else waited: a
// turn is one handler, from when it says that it begins until the loop has the thread again.
//
// It belongs to the io_context, so that whoever has that finds it: TurnClock::of(io).
#pragma once

#include <boost/asio/execution_context.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <chrono>
#include <utility>

#include "broker/net/clock.h"
#include "romano/base/time.h"

namespace romano::net {

class TurnClock final : public boost::asio::execution_context::service {
public:
    using key_type = TurnClock;
    static inline boost::asio::execution_context::id id;

    /// longest() looks back over one to two of them.
    static constexpr Duration window = std::chrono::seconds{30};

    explicit TurnClock(boost::asio::execution_context& context) : service(context) {}
    [[nodiscard]] static TurnClock& of(boost::asio::io_context& io) {
        return boost::asio::use_service<TurnClock>(io);
    }

    /// A handler begins its work. More than once in a turn is fine: the first counts.
    void begin(Instant time) {
        if (began_ == never) began_ = time;
    }
    [[nodiscard]] bool has_begun() const { return began_ != never; }
    /// The loop has the thread again.
    void end(Instant time);

    /// Of the last half minute to minute before `time`; 0: nothing was done.
    [[nodiscard]] Duration longest(Instant time) const;

private:
    void shutdown() override {}

    Instant began_ = never;
    Instant window_began_ = Instant::min();
    Duration longest_{0};  // in this window
    Duration before_{0};   // in the one before it
};

/// As boost::asio::post, for what another thread has to say: the handler's work is a turn.
template <typename Handler>
void post_turn(boost::asio::io_context& io, Handler handler) {
    boost::asio::post(io, [&clock = TurnClock::of(io), handler = std::move(handler)]() mutable {
        clock.begin(now());
        handler();
    });
}

/// As io.run(), with each turn measured.
void run_in_turns(boost::asio::io_context& io);

}  // namespace romano::net
