#include "overlay/cluster/replication/snapshot_sender.h"

#include <iterator>

namespace romano::cluster {

void SnapshotSender::send(const LogId& to, Snapshot snapshot) {
    const LogId log = snapshot.log();
    underway_.insert_or_assign({to, log}, std::move(snapshot));
}

void SnapshotSender::on_request(Effects& effects, BrokerId from, const SnapshotRequest& request,
                                const Logs& logs, const Membership& membership) {
    const Peer* peer = membership.find(from);
    if (peer == nullptr) return;
    const LogId& to = peer->beacon.log;
    if (is_sending(to, request.log)) return;
    if (request.log != logs.own.id()) {
        const auto log = logs.peers.find(request.log);
        if (log == logs.peers.end() || !log->second.is_frozen()) return;
        return send(to, Snapshot(*log, request.after));
    }
    if (request.after != 0 && send_tail(logs.own.history(), {logs.own.id(), logs.own.last()},
                                        request.after, from, effects.peers)) {
        return;
    }
    send(to, Snapshot(effects.broker, logs));
}

void SnapshotSender::on_own_event(const LogId& own, const broker::LogEvent& event) {
    for (auto& [key, snapshot] : underway_) {
        if (snapshot.log() == own) snapshot.on_event(event);
    }
}

void SnapshotSender::carry_on(Effects& effects, const Logs& logs, const Membership& membership) {
    if (underway_.empty() || effects.now < next_turn_) return;
    next_turn_ = effects.now + effects.times.snapshot_pieces_every();
    for (auto at = underway_.begin(); at != underway_.end();) {
        const LogId& to = at->first.first;
        const Peer* peer = membership.find(to.broker);
        const bool is_there = peer != nullptr && peer->beacon.log == to;
        at = is_there && send_some(effects, to, at->second, logs) ? std::next(at)
                                                                  : underway_.erase(at);
    }
}

bool SnapshotSender::send_some(Effects& effects, const LogId& to, Snapshot& snapshot,
                               const Logs& logs) {
    for (int i = 0; i < parts_at_once; ++i) {
        SnapshotPart part = snapshot.next(effects.broker, logs);
        const bool is_last = part.last;
        effects.peers.push_back({to.broker, std::move(part)});
        if (is_last) return false;
    }
    return true;
}

}  // namespace romano::cluster
