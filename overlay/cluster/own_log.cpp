#include "overlay/cluster/own_log.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace romano::cluster {
namespace {

// A batch of small events fills a few UDP datagrams; larger ones only add latency.
constexpr std::size_t events_per_batch = 256;

}  // namespace

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

bool OwnLog::send_again(BrokerId to, Seq after, Outbox& out) const {
    if (after > history_.last() || !history_.reaches_back_to(after)) return false;
    send_tail(history_, {id_, after}, std::min(after + tail_events_most, history_.last()), to, out);
    return true;
}

void send_tail(const LogHistory& history, LogPosition after, Seq through, BrokerId to,
               Outbox& out) {
    while (after.seq < through) {
        const std::size_t most = std::min<Seq>(events_per_batch, through - after.seq);
        LogTail tail{.log = after.log,
                     .first_seq = after.seq + 1,
                     .events = history.events_after(after.seq, most)};
        after.seq += tail.events.size();
        out.push_back({to, std::move(tail)});
    }
}

}  // namespace romano::cluster
