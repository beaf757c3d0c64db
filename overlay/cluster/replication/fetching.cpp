#include "overlay/cluster/replication/fetching.h"

#include <algorithm>
#include <set>

#include "overlay/cluster/replication/own_log.h"

namespace romano::cluster {

void Fetching::on_view(const ViewAnnouncement& announcement) {
    removed_.clear();
    for (const LogPosition& end : announcement.ends) removed_[end.log].end = end.seq;
    waits_.clear();
    is_new_view_ = true;
    next_look_ = Instant::min();
}

void Fetching::carry_on(Effects& effects, const PeerLogs& logs, const Membership& membership,
                        const View& view, const Inherits& inherits) {
    const auto received = [&logs](const LogId& id) {
        const auto log = logs.find(id);
        return log == logs.end() ? 0 : log->second.received();
    };
    std::erase_if(removed_, [&](const auto& entry) {
        const auto& [id, removed] = entry;
        if (received(id) >= removed.end) return true;
        return (removed.has_publishes || effects.broker.cursor(id) >= removed.end) && !inherits(id);
    });
    if (effects.now < next_look_) return;
    next_look_ = effects.now + effects.times.beacon_every;
    std::erase_if(waits_, [&](const auto& entry) {
        const auto log = logs.find(entry.first);
        return !removed_.contains(entry.first) && (log == logs.end() || !lacks(*log));
    });
    std::erase_if(missing_, [&](const auto& entry) {
        const auto log = logs.find(entry.first);
        return log == logs.end() || log->second.is_frozen() || !membership.is_alive(entry.first);
    });
    const Instant gaps_since = is_new_view_ ? Instant::min() : effects.now;
    is_new_view_ = false;
    for (const auto& log : logs) {
        const LogId& id = log.first;
        const bool has_gap = lacks(log);
        const bool lacks_messages = log.second.mirror().is_any_unresolved();
        // Of most nothing is lacking: they are looked up no further.
        if (!has_gap && !lacks_messages && !missing_.contains(id)) continue;
        if (log.second.is_frozen() || !membership.is_alive(id)) continue;
        if (has_gap) ask(effects, {id, received(id)}, gaps_since, id.broker);
        ask_for_messages(effects, log, logs);
    }
    for (auto& [id, removed] : removed_) {
        const LogPosition after{id, received(id)};
        const auto holder = next_holder(after, membership, view);
        if (holder) ask(effects, after, effects.now, *holder);
    }
}

bool Fetching::lacks(const PeerLogs::value_type& log) const {
    const auto removed = removed_.find(log.first);
    const Seq end = removed != removed_.end() ? removed->second.end : log.second.known_end();
    return log.second.received() < end;
}

/// The member after the one that was asked last that says that it holds more.
std::optional<BrokerId> Fetching::next_holder(const LogPosition& after,
                                              const Membership& membership,
                                              const View& view) const {
    const auto wait = waits_.find(after.log);
    const BrokerId asked = wait == waits_.end() ? BrokerId{} : wait->second.asked;
    std::optional<BrokerId> first;
    for (const LogId& member : view.members) {
        const Peer* peer = membership.find(member.broker);
        if (peer == nullptr || !peer->alive) continue;
        if (peer->beacon.applied_through(after.log) <= after.seq) continue;
        if (member.broker > asked) return member.broker;
        if (!first) first = member.broker;
    }
    return first;
}

void Fetching::ask(Effects& effects, const LogPosition& after, Instant missing_since,
                   BrokerId holder) {
    if (after.seq == 0) missing_since = Instant::min();
    Wait& wait = waits_.try_emplace(after.log, Wait{missing_since, after.seq, {}}).first->second;
    if (wait.after != after.seq) wait = {effects.now, after.seq, wait.asked};  // it comes
    if (effects.now < wait.since + effects.times.fetched_again_after(wait.times_asked)) return;
    send(effects, wait, after, holder);
}

void Fetching::send(Effects& effects, Wait& wait, const LogPosition& after, BrokerId holder) {
    const int times_asked = wait.after == after.seq ? wait.times_asked + 1 : 1;
    wait = {effects.now, after.seq, holder, times_asked};
    if (const auto removed = removed_.find(after.log); removed != removed_.end()) {
        removed->second.next_part = 0;
    }
    effects.peers.push_back({holder, Fetch{after, self_}});
}

void Fetching::on_events(Effects& effects, BrokerId from, const PeerLogs::value_type& log,
                         std::size_t events) {
    const auto wait = waits_.find(log.first);
    if (wait == waits_.end() || wait->second.asked != from || events < events_per_batch) return;
    const Seq received = log.second.received();
    if (received > wait->second.after && lacks(log)) {
        send(effects, wait->second, {log.first, received}, from);
    }
}

void Fetching::ask_for_messages(Effects& effects, const PeerLogs::value_type& log,
                                const PeerLogs& logs) {
    const auto& [id, held] = log;
    auto at = missing_.find(id);
    if (at == missing_.end()) {
        at = missing_.emplace(id, Missing{held.mirror().unresolved(), effects.now}).first;
        std::set<LogId> ended;
        for (const LogPosition& message : at->second.messages) {
            if (!logs.contains(message.log)) ended.insert(message.log);
        }
        for (const LogId& log_before_us : ended) {
            effects.peers.push_back({id.broker, Fetch{{log_before_us, 0}, self_}});
        }
    }
    Missing& missing = at->second;
    std::erase_if(missing.messages, [&mirror = held.mirror()](const LogPosition& message) {
        return !mirror.is_unresolved(message);
    });
    if (missing.messages.empty()) {
        missing_.erase(at);
    } else if (effects.now >= missing.since + effects.times.message_waited_for()) {
        missing.since = effects.now;
        effects.peers.push_back({id.broker, Fetch{{id, 0}, self_}});
    }
}

bool Fetching::on_last_publishes(Instant now, BrokerId from, const SnapshotPart& part) {
    const auto wait = waits_.find(part.as_of.log);
    if (wait == waits_.end() || wait->second.asked != from) return false;
    const auto at = removed_.find(part.as_of.log);
    if (at == removed_.end() || part.part != at->second.next_part) return false;
    Removed& removed = at->second;
    ++removed.next_part;
    removed.has_publishes = part.last && part.as_of.seq >= removed.end;
    on_part(now, part.as_of.log);
    return true;
}

bool Fetching::awaits(const LogPosition& event) const {
    const auto removed = removed_.find(event.log);
    return removed != removed_.end() && !removed->second.has_publishes &&
           event.seq <= removed->second.end;
}

}  // namespace romano::cluster
