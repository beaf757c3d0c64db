// The broker's own log on its way to the peers: everything appended in one input leaves as one
// batch; what a peer missed is sent again while it is kept.
//
// Notes of what happened to deliveries leave later, when nobody waits for them: with the next event
// that is more than that, or the next beacon. Should they be lost with the broker, then its heir
// repeats deliveries at QoS 1.
#pragma once

#include <cstddef>

#include "overlay/cluster/envelope.h"
#include "overlay/cluster/replication/log_history.h"

namespace romano::cluster {

class OwnLog {
public:
    OwnLog(LogId id, std::size_t events_kept) : id_(id), history_(events_kept) {}

    void append(Seq seq, const LogEventPtr& event);
    /// Batches of what was appended since the last time, to all, unless all of it may wait.
    /// `awaited`: how far clients wait for the log.
    void flush(Seq awaited, Outbox& out);
    /// A beacon is about to say how far the log goes: the next flush() sends all.
    void accompany_beacon() { accompanies_beacon_ = true; }

    [[nodiscard]] LogId id() const { return id_; }
    [[nodiscard]] Seq last() const { return history_.last(); }
    [[nodiscard]] const LogHistory& history() const { return history_; }
    [[nodiscard]] LogHistory& history() { return history_; }

private:
    LogId id_;
    LogHistory history_;
    Seq flushed_ = 0;
    Seq urgent_ = 0;  // the last event that is more than a note
    bool accompanies_beacon_ = false;
};

/// A batch of small events fills a few UDP datagrams; larger ones only add latency.
inline constexpr std::size_t events_per_batch = 256;

/// Sends the first events after `after` and up to `end`, when they are kept: one batch. Who applied
/// it asks for the next, so that neither side is busy with a long tail for longer than its peers
/// are patient. False when `history` does not reach back to there.
bool send_tail(const LogHistory& history, const LogPosition& end, Seq after, BrokerId to,
               Outbox& out);

}  // namespace romano::cluster
