// How far this broker says that it holds each peer's log: no event that tells of a message counts
// before the message is held too, in the log in which it was published.
//
// A home speaks to a client of a peer's message as soon as enough peers hold that it works on it.
// If one of these lacked the message, and outlived both the home and the publisher's broker, no log
// would have the message: its publisher would say it again, and the client would get it twice.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <vector>

#include "broker/core/log_event.h"
#include "broker/core/log_position.h"

namespace romano::cluster {

class Acknowledgements {
public:
    /// The publish that the log `by` names is here, or lies beyond where a view ended its log.
    using IsHeld = std::function<bool(const broker::LogId& by, const broker::LogPosition& publish)>;

    /// The next event of that log, which is `seq` of it, was applied.
    void on_event(const broker::LogId& log, broker::Seq seq, const broker::LogEvent& event,
                  const IsHeld& is_held);
    /// A snapshot up to `seq` replaced the log, and this is one of its sessions.
    void on_session(const broker::LogId& log, broker::Seq seq, const broker::SessionImage& session,
                    const IsHeld& is_held);
    /// How far the log counts as held, when it is applied up to `applied`.
    [[nodiscard]] broker::Seq through(const broker::LogId& log, broker::Seq applied,
                                      const IsHeld& is_held) const;
    /// Forgets messages that are held by now, and returns the logs of which more counts since.
    [[nodiscard]] std::vector<broker::LogId> advance(const IsHeld& is_held);
    void forget(const broker::LogId& log) { waiting_.erase(log); }

private:
    struct Waiting {
        broker::Seq seq = 0;
        broker::LogPosition publish;
    };
    void wait(const broker::LogId& log, broker::Seq seq, const broker::LogPosition& publish,
              const IsHeld& is_held);

    static constexpr std::size_t waiting_most = 20'000;     // a log; beyond: counts at once
    std::map<broker::LogId, std::deque<Waiting>> waiting_;  // none is empty
};

}  // namespace romano::cluster
