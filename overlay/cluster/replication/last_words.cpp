#include "overlay/cluster/replication/last_words.h"

#include <algorithm>

namespace romano::cluster {

void LastWords::on_view(const ViewAnnouncement& announcement) {
    awaited_.clear();
    for (const LogPosition& end : announcement.ends) awaited_.emplace(end.log, Awaited{end.seq});
}

void LastWords::carry_on(Effects& effects, const PeerLogs& logs, const Membership& membership,
                         const View& view) {
    const auto applied = [&logs](const LogId& log) {
        const auto held = logs.find(log);
        return held == logs.end() ? 0 : held->second.applied();
    };
    std::erase_if(awaited_, [&](const auto& entry) {
        const auto& [log, awaited] = entry;
        return applied(log) >= awaited.end || effects.broker.cursor(log) >= awaited.end;
    });
    for (auto& [log, awaited] : awaited_) {
        const bool may_be_completed = applied(log) > 0;  // a tail is on its way, if there is one
        if (may_be_completed && awaited.asked_at == Instant::min()) awaited.asked_at = effects.now;
        const Duration patience = may_be_completed ? effects.times.last_words_asked_after()
                                                   : effects.times.tail_asked_again_after();
        if (effects.now < awaited.asked_at + patience) continue;
        const LogPosition end{log, awaited.end};
        const auto holder = std::ranges::find_if(view.members, [&](const LogId& member) {
            const Peer* peer = membership.find(member.broker);
            return peer != nullptr && peer->alive &&
                   peer->beacon.applied_through(end.log) >= end.seq;
        });
        if (holder == view.members.end()) continue;
        awaited.asked_at = effects.now;
        awaited.next_part = 0;
        effects.peers.push_back({holder->broker, SnapshotRequest{log, effects.broker.cursor(log)}});
    }
}

bool LastWords::on_part(Effects& effects, const SnapshotPart& part) {
    const auto awaited = awaited_.find(part.as_of.log);
    if (awaited == awaited_.end() || part.part != awaited->second.next_part) return false;
    ++awaited->second.next_part;
    awaited->second.asked_at = effects.now;  // they come
    for (const auto& message : part.publishes) {
        effects.broker.on_peer_message(effects.now, message, effects.clients);
    }
    if (part.last) effects.broker.advance_cursor(part.as_of);
    return true;
}

}  // namespace romano::cluster
