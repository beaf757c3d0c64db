// What removed brokers published last and this member never heard. A newcomer may be home to
// subscribers already when a broker dies of whose log it holds nothing yet; and one that was cut
// off may lack more of it than others keep. It asks a member that holds that log for the publishes.
// For its sessions alone: it never adopts from such a log.
#pragma once

#include <map>

#include "overlay/cluster/agreement/membership.h"
#include "overlay/cluster/effects.h"
#include "overlay/cluster/replication/peer_log.h"

namespace romano::cluster {

class LastWords {
public:
    void on_view(const ViewAnnouncement& announcement);
    /// Asks for what is still awaited.
    void carry_on(Effects& effects, const PeerLogs& logs, const Membership& membership,
                  const View& view);
    /// False when it was not asked for, or does not follow what came.
    bool on_part(Effects& effects, const SnapshotPart& part);
    /// That event lies before the end and is not here.
    [[nodiscard]] bool await(const LogPosition& event) const {
        const auto awaited = awaited_.find(event.log);
        return awaited != awaited_.end() && event.seq <= awaited->second.end;
    }
    void restart() { awaited_.clear(); }

private:
    struct Awaited {
        Seq end;
        Instant asked_at = Instant::min();
        std::uint32_t next_part = 0;
    };

    std::map<LogId, Awaited> awaited_;
};

}  // namespace romano::cluster
