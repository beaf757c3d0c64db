// All that is a broker's own, for a peer that cannot continue its log: sessions, publishes that
// somebody's cursor has not passed, cursors. And all retained messages that it knows: who wrote one
// may be dead, and nobody has noticed yet. Or of a removed broker's log, its last publishes
// (last_words.h). In parts, made one by one: under load there are a hundred thousand publishes, and
// to look at all of them at once takes longer than peers wait for a beacon.
#pragma once

#include <cstddef>
#include <vector>

#include "broker/core/broker_core.h"
#include "overlay/cluster/ownership/adoption.h"

namespace romano::cluster {

class Snapshot {
public:
    /// Of the own log.
    Snapshot(const broker::BrokerCore& broker, const Logs& logs);
    /// Of a removed broker's log: the publishes after `after` that are kept.
    Snapshot(const PeerLogs::value_type& removed, Seq after);

    [[nodiscard]] const LogId& log() const { return as_of_.log; }
    /// The next part; the last one says so, and none follows it. What was forgotten since is not in
    /// it: everybody has it.
    [[nodiscard]] SnapshotPart next(const Logs& logs);

private:
    LogPosition as_of_;
    std::vector<broker::SessionImage> sessions_;
    std::vector<MessagePtr> retained_;
    std::vector<LogPosition> cursors_;
    std::size_t next_session_ = 0;
    std::size_t next_retained_ = 0;
    Seq published_;  // the last one that is in a part
    std::uint32_t next_part_ = 0;
};

}  // namespace romano::cluster
