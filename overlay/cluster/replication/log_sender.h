// Answers to Fetch: a batch of the events that are asked for, where they are kept; else a snapshot,
// some parts at a time. Who asks again meanwhile is not sent a second one.
#pragma once

#include <map>
#include <utility>

#include "overlay/cluster/agreement/membership.h"
#include "overlay/cluster/effects.h"
#include "overlay/cluster/replication/snapshot.h"
#include "romano/base/time.h"

namespace romano::cluster {

class LogSender {
public:
    void on_fetch(Effects& effects, const Fetch& fetch, const Logs& logs,
                  const Membership& membership, const Departures& departures);
    /// The next event of the own log.
    void on_own_event(const LogId& own, const broker::LogEvent& event);
    /// Sends the next parts when it is time. What was for an earlier life of a peer is dropped.
    /// All of the broker's events must stand in the own log.
    void carry_on(Effects& effects, const Logs& logs, const Membership& membership,
                  const Departures& departures);
    /// Instant::max() when nothing is under way.
    [[nodiscard]] Instant next_wakeup() const {
        return underway_.empty() ? Instant::max() : next_turn_;
    }

    // With 10 ms between beacons 100,000 messages a second: less than half of what a peer takes in.
    static constexpr int parts_at_once = 3;

private:
    /// False when the last part is among them.
    static bool send_some(Effects& effects, const LogId& to, Snapshot& snapshot, const Logs& logs,
                          const Departures& departures);

    std::map<std::pair<LogId, LogId>, Snapshot> underway_;  // by receiver and log
    Instant next_turn_ = Instant::min();
};

}  // namespace romano::cluster
