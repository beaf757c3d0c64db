// How long what stands in logs is kept, the own one and the peers': an event until every member
// holds it and a batch of newer ones is there, a publish until every home has worked through it,
// and a removed broker's log for a while, because it may come back.
#pragma once

#include <map>
#include <vector>

#include "overlay/cluster/agreement/membership.h"
#include "overlay/cluster/agreement/view_change.h"
#include "overlay/cluster/ownership/adoption.h"
#include "overlay/cluster/replication/peer_log.h"
#include "overlay/cluster/replication/watermark.h"
#include "overlay/cluster/times.h"
#include "romano/base/time.h"

namespace romano::cluster {

class LogKeeping {
public:
    /// Empties the logs of removed brokers whose time is over, and names those that are empty now.
    [[nodiscard]] std::vector<LogId> expire(Instant now, const Times& times, PeerLogs& logs,
                                            const Membership& members, const ViewChange& views);
    /// Forgets what nobody can need any more.
    void forget_passed(Instant now, const Times& times, Logs logs, const Membership& members,
                       const Watermark& watermark);
    /// There was more to forget than fits a moment: go on soon.
    [[nodiscard]] bool is_behind() const { return is_behind_; }

private:
    std::map<LogId, Instant> gone_since_;
    bool is_behind_ = false;
};

/// Nobody can write that log any more, and nobody holds it. A broker writes one log a life, and
/// none of an earlier life once a later one was heard; while a peer still holds such a log, a
/// session that comes to it must say what was worked through.
[[nodiscard]] bool is_over(const LogId& log, Logs logs, const Membership& members);

}  // namespace romano::cluster
