#include "overlay/cluster/ownership/arrivals.h"

#include <algorithm>
#include <set>
#include <utility>

namespace romano::cluster {

void Arrivals::on_event(const Effects& effects, const PeerLog& log, const broker::LogEvent& event) {
    const LogPosition at{log.mirror().log(), log.applied()};
    const auto called_off = called_off_.find(at.log);
    if (called_off != called_off_.end() && at.seq <= called_off->second) return;
    if (const auto* moved = std::get_if<broker::SessionMoved>(&event)) {
        const MovedSession* session = log.moved(moved->header.client_id, at.seq);
        if (session != nullptr && session->to == self_) put(effects, at.log, *session);
    } else if (const auto* sealed = std::get_if<broker::Sealed>(&event)) {
        if (sealed->to != self_) return;
        arrivals_.push_back({at, {}, sealed->address, {}, effects.now});
    }
}

void Arrivals::put(const Effects& effects, const LogId& from, const MovedSession& session) {
    arrivals_.push_back({.moved = {from, session.at},
                         .client = session.image.header.client_id,
                         .after = session.image.worked_through,
                         .until = effects.now + effects.times.former_home_waited_for()});
}

void Arrivals::on_snapshot(const Effects& effects, const PeerLog& log) {
    const LogId& from = log.mirror().log();
    const auto called_off = called_off_.find(from);
    const Seq after = called_off == called_off_.end() ? 0 : called_off->second;
    for (const auto& [client, session] : log.moved()) {
        if (session.to == self_ && session.at > after) put(effects, from, session);
    }
}

void Arrivals::on_end(const Effects& effects, const PeerLog& log) {
    if (called_off_.erase(log.mirror().log()) != 0) on_snapshot(effects, log);
}

void Arrivals::forget_waiting(const PeerLogs& logs) {
    std::erase_if(arrivals_, [&logs](const Arrival& arrival) {
        const auto log = logs.find(arrival.moved.log);
        return log == logs.end() || !log->second.is_frozen();
    });
    for (const auto& [id, log] : logs) {
        if (!log.is_frozen()) called_off_[id] = log.known_end();
    }
    std::erase_if(called_off_, [&logs](const auto& entry) { return !logs.contains(entry.first); });
}

void Arrivals::heed(Instant now, const IsWorkedThrough& is_worked_through) {
    for (Arrival& arrival : arrivals_) {
        if (now >= arrival.until) arrival.after.clear();
        std::erase_if(arrival.after, is_worked_through);
    }
}

std::vector<Arrivals::Settled> Arrivals::carry_on(Effects& effects, const Logs& logs,
                                                  const HomeOfHigher& home_of_higher,
                                                  Departures& departures) {
    std::vector<Settled> settled;
    std::set<LogId> unfinished;
    const auto is_over = [&](const Arrival& arrival) {
        const auto& [from, at] = arrival.moved;
        const auto log = logs.peers.find(from);
        if (log == logs.peers.end()) return true;
        if (arrival.client.empty()) {
            if (unfinished.contains(from)) return false;
            settled.push_back({from.broker, arrival.address});
            return true;
        }
        if (!arrival.after.empty()) {
            unfinished.insert(from);
            return false;
        }
        const MovedSession* session = log->second.moved(arrival.client, at);
        if (session == nullptr) return true;  // taken back
        if (departures.crosses(*session, from)) {
            unfinished.insert(from);
            return false;
        }
        --allowed_;
        const auto speaks = home_of_higher(session->image.header);
        if (speaks && effects.broker.header(arrival.client) == nullptr) {
            departures.pass_on(effects, logs, session->image, *speaks, arrival.moved);
        } else {
            departures.adopt(effects, logs, session->image, arrival.moved);
        }
        log->second.on_arrived(arrival.client, at);
        return true;
    };
    // There are as many as a home has sessions, and each input comes here: nobody looks beyond
    // those that this turn may adopt.
    auto next = arrivals_.begin();
    auto last_left = next;
    for (; next != arrivals_.end() && (allowed_ > 0 || next->client.empty()); ++next) {
        if (is_over(*next)) continue;
        if (last_left != next) *last_left = std::move(*next);
        ++last_left;
    }
    is_half_done_ = next != arrivals_.end();
    arrivals_.erase(last_left, next);
    return settled;
}

bool Arrivals::holds(const broker::ClientId& client) const {
    return std::ranges::count(arrivals_, client, &Arrival::client) > 0;
}

}  // namespace romano::cluster
