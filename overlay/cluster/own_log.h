// The broker's own log on its way to the peers: everything appended in one input leaves as one
// batch; what a peer missed is sent again while it is kept.
#pragma once

#include <cstddef>
#include <optional>

#include "overlay/cluster/envelope.h"
#include "overlay/cluster/log_history.h"

namespace romano::cluster {

/// More than a peer is sent of a tail at once would keep the sender from its beacons; the peer asks
/// for the next piece when it has applied this one.
inline constexpr Seq tail_events_most = 4'096;

class OwnLog {
public:
    OwnLog(LogId id, std::size_t events_kept) : id_(id), history_(events_kept) {}

    void append(Seq seq, LogEvent event);
    /// Batches of what was appended since the last call: to all.
    void flush(Outbox& out);
    /// Answers a peer that holds the log up to `after`, with a piece of what follows. False when
    /// that is too long ago: it needs a snapshot.
    bool send_again(BrokerId to, Seq after, Outbox& out) const;

    [[nodiscard]] LogId id() const { return id_; }
    [[nodiscard]] Seq last() const { return history_.last(); }
    [[nodiscard]] const LogHistory& history() const { return history_; }
    [[nodiscard]] LogHistory& history() { return history_; }

private:
    LogId id_;
    LogHistory history_;
    Seq flushed_ = 0;
};

/// Sends the events after `after`, up to and including `through`, as LogTails. `history` must reach
/// back to there.
void send_tail(const LogHistory& history, LogPosition after, Seq through, BrokerId to, Outbox& out);

}  // namespace romano::cluster
