// The broker's own log on its way to the peers: everything appended in one input leaves as one
// batch; what a peer missed is sent again while it is kept.
#pragma once

#include <cstddef>
#include <optional>

#include "overlay/cluster/envelope.h"
#include "overlay/cluster/log_history.h"

namespace romano::cluster {

class OwnLog {
public:
    OwnLog(LogId id, std::size_t events_kept) : id_(id), history_(events_kept) {}

    void append(Seq seq, LogEvent event);
    /// Batches of what was appended since the last call: to all.
    void flush(Outbox& out);
    /// Answers a peer that holds the log up to `after`. False when that is too long ago: it needs
    /// a snapshot.
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

/// Sends the events after `after` as LogTails. `history` must reach back to there.
void send_tail(const LogHistory& history, LogId log, Seq after, BrokerId to, Outbox& out);

}  // namespace romano::cluster
