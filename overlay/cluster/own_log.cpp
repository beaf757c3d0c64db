#include "overlay/cluster/own_log.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace romano::cluster {

void OwnLog::append(Seq seq, LogEvent event) {
    assert(seq == history_.last() + 1);
    (void)seq;
    history_.append(std::move(event));
}

void OwnLog::flush(Outbox& out) {
    while (flushed_ < history_.last()) {
        // Only events that were dropped for want of room before they were sent are skipped.
        if (!history_.reaches_back_to(flushed_)) {
            flushed_ = history_.last() - history_.events_kept();
        }
        LogBatch batch{.log = id_,
                       .first_seq = flushed_ + 1,
                       .events = history_.events_after(flushed_, events_per_batch)};
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
        out.push_back({to, LogTail{end.log, after + 1, std::move(events), end.seq}});
    }
    return true;
}

}  // namespace romano::cluster
