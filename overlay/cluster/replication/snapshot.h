// All that is a broker's own, for a peer that cannot continue its log: sessions, also those that it
// moved and that have not arrived, publishes that somebody's cursor has not passed, cursors. And
// all retained messages that it knows: who wrote one may be dead, and nobody has noticed yet. Or of
// a removed broker's log, its last publishes (fetching.h). In parts, made one by one: under load
// there are ten thousand sessions and a hundred thousand publishes, and to look at all of them at
// once takes longer than peers wait for a beacon.
//
// Its sessions go on changing meanwhile. Those that change after they were sent are sent again,
// and the last part has what then is still to be sent of them, so that the whole is as of one
// event.
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_set>
#include <vector>

#include "broker/core/broker_core.h"
#include "overlay/cluster/ownership/adoption.h"
#include "overlay/cluster/ownership/departures.h"

namespace romano::cluster {

class Snapshot {
public:
    /// Of the own log.
    Snapshot(const broker::BrokerCore& broker, const Logs& logs, const Departures& departures);
    /// Of a removed broker's log: the publishes after `after` that are kept.
    Snapshot(const PeerLogs::value_type& removed, Seq after);

    /// The next one of the own log.
    void on_event(const broker::LogEvent& event);
    /// The next part; the last one says so, and none follows it. What was forgotten since is not in
    /// it: everybody has it. All of the broker's events must stand in the own log.
    [[nodiscard]] SnapshotPart next(const broker::BrokerCore& broker, const Logs& logs,
                                    const Departures& departures);

    /// Then what goes on changing is sent at once.
    static constexpr int rounds_most = 3;

private:
    static void put_session(const broker::BrokerCore& broker, const Departures& departures,
                            const broker::ClientId& client, SnapshotPart& part);
    /// False when more is to come before the last part.
    [[nodiscard]] bool put_sessions(const broker::BrokerCore& broker, const Departures& departures,
                                    SnapshotPart& part);
    [[nodiscard]] bool put_publishes(const Logs& logs, SnapshotPart& part);

    LogId log_;
    Seq since_;
    std::vector<broker::ClientId> to_send_;
    std::unordered_set<broker::ClientId> changed_;  // and were not sent since
    int rounds_ = 1;
    std::vector<MessagePtr> retained_;
    std::size_t next_retained_ = 0;
    Seq published_ = 0;  // the last one that is in a part
    std::uint32_t next_part_ = 0;
};

}  // namespace romano::cluster
