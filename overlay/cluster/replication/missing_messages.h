// Messages that deliveries of a peer's sessions name, and that came from nowhere: they were
// published at a broker that came and died while this one was away. Their log is held by nobody
// here; the home of the deliveries has them, and is asked for a snapshot.
#pragma once

#include <map>
#include <vector>

#include "overlay/cluster/agreement/membership.h"
#include "overlay/cluster/effects.h"
#include "overlay/cluster/replication/peer_log.h"

namespace romano::cluster {

class MissingMessages {
public:
    /// Asks for what has been missing for long. Most of what is missing comes a moment later, with
    /// its publisher's log.
    void carry_on(Effects& effects, const PeerLogs& logs, const Membership& membership);
    /// Those that the part of a snapshot brings, however old it is.
    [[nodiscard]] static std::vector<MessagePtr> found_in(const SnapshotPart& part,
                                                          const PeerLog& log);
    void restart() { awaited_.clear(); }

private:
    struct Awaited {
        std::vector<LogPosition> positions;
        Instant since;
    };

    std::map<LogId, Awaited> awaited_;  // by the log whose mirror lacks them
};

}  // namespace romano::cluster
