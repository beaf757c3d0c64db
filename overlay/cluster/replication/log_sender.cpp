#include "overlay/cluster/replication/log_sender.h"

#include <iterator>

namespace romano::cluster {

/// Who holds nothing of a log is sent a snapshot, though its first events may be kept.
void LogSender::on_fetch(Effects& effects, const Fetch& fetch, const Logs& logs,
                         const Membership& membership, const Departures& departures) {
    const auto& [id, after] = fetch.after;
    const bool is_own = id == logs.own.id();
    const auto log = logs.peers.find(id);
    if (!is_own && log == logs.peers.end()) return;
    const Seq end = is_own ? logs.own.last() : log->second.end();
    if (after != 0 && send_tail(*logs.history_of(id), {id, end}, after, fetch.to, effects.peers)) {
        return;
    }
    const Peer* peer = membership.find(fetch.to);
    if (peer == nullptr) return;
    const std::pair key{peer->beacon.log, id};
    if (is_own) {
        underway_.try_emplace(key, effects.broker, logs, departures);
    } else if (log->second.is_frozen()) {
        underway_.try_emplace(key, *log, after);
    }
}

void LogSender::on_own_event(const LogId& own, const broker::LogEvent& event) {
    for (auto& [key, snapshot] : underway_) {
        if (key.second == own) snapshot.on_event(event);
    }
}

void LogSender::carry_on(Effects& effects, const Logs& logs, const Membership& membership,
                         const Departures& departures) {
    if (underway_.empty() || effects.now < next_turn_) return;
    next_turn_ = effects.now + effects.times.snapshot_pieces_every();
    for (auto at = underway_.begin(); at != underway_.end();) {
        const LogId& to = at->first.first;
        const Peer* peer = membership.find(to.broker);
        const bool is_there = peer != nullptr && peer->beacon.log == to;
        at = is_there && send_some(effects, to, at->second, logs, departures) ? std::next(at)
                                                                              : underway_.erase(at);
    }
}

bool LogSender::send_some(Effects& effects, const LogId& to, Snapshot& snapshot, const Logs& logs,
                          const Departures& departures) {
    for (int i = 0; i < parts_at_once; ++i) {
        SnapshotPart part = snapshot.next(effects.broker, logs, departures);
        const bool is_last = part.last;
        effects.peers.push_back({to.broker, std::move(part)});
        if (is_last) return false;
    }
    return true;
}

}  // namespace romano::cluster
