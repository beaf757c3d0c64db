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

/// How far all others hold a peer's log, and have worked through it.
struct Common {
    LogId log;
    Seq held;
    Seq passed;
};

/// Lowers what is common to all by what `positions` say of one; both are in the order of logs.
void lower(std::vector<Common>& common, Seq Common::*which, const LogId& of,
           const std::vector<LogPosition>& positions) {
    auto at = positions.begin();
    for (Common& one : common) {
        while (at != positions.end() && at->log < one.log) ++at;
        if (one.log == of) continue;
        Seq& least = one.*which;
        least = std::min(least, at != positions.end() && at->log == one.log ? at->seq : 0);
    }
}

/// A removed broker may come back as a home that has not seen what was published since.
std::vector<Common> common_to_all(const PeerLogs& logs, const Membership& members) {
    constexpr Seq endless = std::numeric_limits<Seq>::max();
    const std::vector<LogPosition> none;
    std::vector<Common> common;
    common.reserve(logs.size());
    for (const auto& [id, log] : logs) common.push_back({id, endless, endless});
    for (const auto& [id, log] : logs) {
        lower(common, &Common::passed, id, log.mirror().cursors());
        if (log.is_frozen()) continue;
        const Peer* peer = members.find(id.broker);
        lower(common, &Common::held, id, peer == nullptr ? none : peer->beacon.applied);
    }
    return common;
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

    const std::vector<Common> common = common_to_all(logs.peers, members);
    std::size_t place = 0;
    for (auto& [id, log] : logs.peers) {
        const Common& others = common[place++];
        if (log.is_frozen()) continue;
        forget(log.history(), std::min(log.applied(), others.held),
               std::min(log.applied(), others.passed));
    }
}

bool is_over(const LogId& log, Logs logs, const Membership& members) {
    const bool is_held = std::ranges::any_of(members.peers(), [&log](const auto& entry) {
        return entry.second.beacon.held_of(log).has_value();
    });
    if (is_held || logs.peers.contains(log)) return false;
    if (log.broker == logs.own.id().broker) return log.incarnation < logs.own.id().incarnation;
    const Peer* peer = members.find(log.broker);
    return peer != nullptr && log.incarnation < peer->beacon.log.incarnation;
}

}  // namespace romano::cluster
