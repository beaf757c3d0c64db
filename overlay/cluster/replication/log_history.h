// What is kept of one broker's log after it was applied: events for brokers that lag, and publishes
// that a session may still have to get when its home dies.
//
// The two are kept for different times: an event until every member has applied it, a publish until
// every member's *logged* cursor has passed it. Both are bounded: beyond `most` events the oldest
// go, and a broker that lags by more needs a snapshot; beyond `most` publishes the oldest go, and
// an adopted session whose home lagged by more does not get them.
//
// What may go goes in pieces, an eighth at a time: while a dead broker's log is kept nobody passes
// anything, and to free all of it at once takes longer than peers wait for a beacon. Under full
// load what came to all logs in a tenth of a second already takes a beacon's time, and who is late
// with beacons loses leases.
#pragma once

#include <cstddef>
#include <deque>
#include <limits>
#include <vector>

#include "broker/core/log_event.h"
#include "broker/core/log_position.h"
#include "romano/base/time.h"

namespace romano::cluster {

using broker::LogEvent;
using broker::LogEventPtr;
using broker::LogId;
using broker::LogPosition;
using broker::MessagePtr;
using broker::Seq;

class LogHistory {
public:
    explicit LogHistory(std::size_t most) : most_(most) {}

    /// The event at last() + 1.
    void append(LogEventPtr event);
    /// Goes on after a snapshot: nothing before as_of is here but these publishes, in log order.
    void restart(Seq as_of, std::vector<MessagePtr> publishes);

    [[nodiscard]] Seq last() const { return last_; }
    /// True when all events after `seq` are still here.
    [[nodiscard]] bool reaches_back_to(Seq seq) const { return seq + events_.size() >= last_; }
    /// Up to `most` events after `seq`; call only when reaches_back_to(seq).
    [[nodiscard]] std::vector<LogEventPtr> events_after(Seq seq, std::size_t most) const;
    /// The first `most` publishes after `seq`, in order.
    [[nodiscard]] std::vector<MessagePtr> publishes_after(
        Seq seq, std::size_t most = std::numeric_limits<std::size_t>::max()) const;
    /// Null when it is not kept.
    [[nodiscard]] MessagePtr publish_at(Seq seq) const;

    /// False when more has to go than one piece: call again soon.
    bool forget_events(Seq through);
    /// Every member's logged cursor has passed `through`. Publishes stay for `kept_on` more: a
    /// session on its way between homes still asks for them at its new one, and a newcomer does not
    /// know how far the dead home of such a session had come. False: call again soon.
    bool forget_publishes(Instant now, Duration kept_on, Seq through);
    /// Nobody needs any of it. False: call again soon.
    bool forget_all();

    [[nodiscard]] std::size_t events_kept() const { return events_.size(); }

    static constexpr std::size_t least_at_once = 250;
    static constexpr std::size_t most_at_once = 2'000;  // less than a millisecond

private:
    bool forget_oldest_publishes(Seq through);

    struct Passed {
        Instant at;
        Seq through = 0;
    };

    std::size_t most_;
    Seq last_ = 0;
    std::deque<LogEventPtr> events_;    // the last events_.size() ones, ending at last_
    std::deque<MessagePtr> publishes_;  // by position, ascending
    std::deque<Passed> passed_;         // of the last `kept_on`, and one older
};

}  // namespace romano::cluster
