#include "overlay/cluster/replication/missing_messages.h"

namespace romano::cluster {

void MissingMessages::carry_on(Effects& effects, const PeerLogs& logs,
                               const Membership& membership) {
    const Instant now = effects.now;
    std::erase_if(awaited_, [&](const auto& entry) {
        const auto log = logs.find(entry.first);
        return log == logs.end() || log->second.is_frozen() || !membership.is_alive(entry.first);
    });
    for (const auto& [id, log] : logs) {
        if (log.is_frozen() || !membership.is_alive(id)) continue;
        const auto [at, is_new] = awaited_.try_emplace(id, Awaited{log.mirror().unresolved(), now});
        Awaited& awaited = at->second;
        std::erase_if(awaited.positions, [&log](const LogPosition& position) {
            return !log.mirror().is_unresolved(position);
        });
        if (awaited.positions.empty()) {
            awaited_.erase(at);
        } else if (now >= awaited.since + effects.times.message_waited_for()) {
            awaited.since = now;
            effects.peers.push_back({id.broker, SnapshotRequest{.log = id, .after = 0}});
        }
    }
}

std::vector<MessagePtr> MissingMessages::found_in(const SnapshotPart& part, const PeerLog& log) {
    std::vector<MessagePtr> found;
    for (const auto& session : part.sessions) {
        for (const auto& delivery : session.deliveries) {
            if (delivery.message && log.mirror().is_unresolved(delivery.position)) {
                found.push_back(delivery.message);
            }
        }
    }
    return found;
}

}  // namespace romano::cluster
