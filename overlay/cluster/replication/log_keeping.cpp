#include "overlay/cluster/replication/log_keeping.h"

#include <algorithm>
#include <limits>

#include "overlay/cluster/replication/own_log.h"

namespace romano::cluster {
namespace {

/// An heir may lack the last batch (heirs.h), and was perhaps no member when it was written.
Seq before_last_batch(const LogHistory& history) {
    return history.last() - std::min<Seq>(history.last(), events_per_batch);
}

/// How far peer `by` has applied the log, as its last beacon tells.
Seq applied_by(const LogId& by, const LogId& log, const Membership& members) {
    const Peer* peer = members.find(by.broker);
    return peer == nullptr ? 0 : peer->beacon.applied_through(log);
}

}  // namespace

std::vector<LogId> LogKeeping::expire(Instant now, const Times& times, PeerLogs& logs,
                                      const Membership& members, const ViewChange& views) {
    is_behind_ = false;
    std::vector<LogId> expired;
    for (auto& [id, log] : logs) {
        if (!log.is_frozen() && (views.contains(id) || members.is_alive(id))) {
            gone_since_.erase(id);
            continue;
        }
        const Instant gone_since = gone_since_.try_emplace(id, now).first->second;
        if (now < gone_since + times.removed_log_kept_for()) continue;
        if (!log.history().forget_all()) {
            is_behind_ = true;
            continue;
        }
        gone_since_.erase(id);
        expired.push_back(id);
    }
    return expired;
}

void LogKeeping::forget_passed(Instant now, const Times& times, Logs logs,
                               const Membership& members, const Watermark& watermark) {
    const auto forget = [&](LogHistory& history, Seq held_by_all, Seq passed_by_all) {
        is_behind_ |= !history.forget_events(std::min(held_by_all, before_last_batch(history)));
        is_behind_ |=
            !history.forget_publishes(now, times.passed_publishes_kept_for(), passed_by_all);
    };

    Seq held_by_all = std::numeric_limits<Seq>::max();
    Seq passed_by_all = held_by_all;
    for (const auto& [id, log] : logs.peers) {
        held_by_all = std::min(held_by_all, watermark.held_by(id));
        passed_by_all = std::min(passed_by_all, log.mirror().cursor(logs.own.id()));
    }
    forget(logs.own.history(), held_by_all, passed_by_all);

    for (auto& [id, log] : logs.peers) {
        if (log.is_frozen()) continue;
        held_by_all = log.applied();
        passed_by_all = log.applied();
        for (const auto& [other, held] : logs.peers) {
            if (other == id) continue;
            // A removed broker may come back as a home that has not seen what was published since.
            passed_by_all = std::min(passed_by_all, held.mirror().cursor(id));
            if (held.is_frozen()) continue;
            held_by_all = std::min(held_by_all, applied_by(other, id, members));
        }
        forget(log.history(), held_by_all, passed_by_all);
    }
}

bool is_over(const LogId& log, Logs logs, const Membership& members) {
    const bool is_held = std::ranges::any_of(members.peers(), [&log](const auto& entry) {
        return std::ranges::count(entry.second.beacon.applied, log, &LogPosition::log) > 0;
    });
    if (is_held || logs.peers.contains(log)) return false;
    if (log.broker == logs.own.id().broker) return log.incarnation < logs.own.id().incarnation;
    const Peer* peer = members.find(log.broker);
    return peer != nullptr && log.incarnation < peer->beacon.log.incarnation;
}

}  // namespace romano::cluster
