#include "overlay/cluster/replication/own_log.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace romano::cluster {
namespace {

/// What its writer has done about messages that the log of their publisher holds. A client that
/// relies on it waits for it (broker::Send::after).
bool is_note(const LogEvent& event) {
    return std::holds_alternative<broker::Routed>(event) ||
           std::holds_alternative<broker::Cursor>(event) ||
           std::holds_alternative<broker::DeliveryStarted>(event) ||
           std::holds_alternative<broker::DeliveryEnded>(event);
}

}  // namespace

void OwnLog::append(Seq seq, const LogEventPtr& event) {
    assert(seq == history_.last() + 1);
    if (!is_note(*event)) urgent_ = seq;
    history_.append(event);
}

void OwnLog::flush(Seq awaited, Outbox& out) {
    awaited = std::max(awaited, urgent_);
    const bool fills_a_batch = history_.last() >= flushed_ + events_per_batch;
    const bool may_wait = awaited <= flushed_ && !fills_a_batch;
    if (!std::exchange(accompanies_beacon_, false) && may_wait) return;
    while (flushed_ < history_.last()) {
        // Only events that were dropped for want of room before they were sent are skipped.
        if (!history_.reaches_back_to(flushed_)) {
            flushed_ = history_.last() - history_.events_kept();
        }
        LogBatch batch{.log = id_,
                       .first_seq = flushed_ + 1,
                       .events = history_.events_after(flushed_, events_per_batch),
                       .awaited = awaited > flushed_};
        if (batch.events.empty()) return;
        flushed_ += batch.events.size();
        out.push_back({std::nullopt, std::move(batch)});
    }
}

bool send_tail(const LogHistory& history, const LogPosition& end, Seq after, BrokerId to,
               Outbox& out) {
    if (after > end.seq || !history.reaches_back_to(after)) return false;
    auto events = history.events_after(after, std::min<Seq>(events_per_batch, end.seq - after));
    if (!events.empty()) {
        out.push_back({to, LogBatch{end.log, after + 1, std::move(events)}});
    }
    return true;
}

}  // namespace romano::cluster
