#include "overlay/cluster/own_log.h"

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
    send_tail(history_, id_, after, to, out);
    return true;
}

void send_tail(const LogHistory& history, LogId log, Seq after, BrokerId to, Outbox& out) {
    while (after < history.last()) {
        LogTail tail{.log = log,
                     .first_seq = after + 1,
                     .events = history.events_after(after, events_per_batch)};
        after += tail.events.size();
        out.push_back({to, std::move(tail)});
    }
}

}  // namespace romano::cluster
