// The logs of ClusterCore: the own one goes out; the peers' come in and are applied, gaps are asked
// for, and what nobody needs any more goes.
#include <algorithm>
#include <utility>

#include "overlay/cluster/cluster_core.h"
#include "overlay/cluster/replication/quick_holder.h"

namespace romano::cluster {
namespace {

/// Eight times as much work as others.
bool brings_session(const LogEvent& event) {
    return std::holds_alternative<broker::SessionPut>(event) ||
           std::holds_alternative<broker::SessionMoved>(event);
}

}  // namespace

void ClusterCore::append(Seq seq, const LogEventPtr& event) {
    if (const auto* session = std::get_if<broker::SessionPut>(&*event)) {
        const broker::ClientId& client = session->image.header.client_id;
        peer_sessions_.on_own_session(client, logs_);
        if (is_homed_at_peer(client)) settlement_.on_own_session(client, logs_);
    }
    if (const auto* publish = std::get_if<broker::Published>(&*event)) {
        take_over_.on_publish(publish->message->topic);
    }
    log_sender_.on_own_event(own_.id(), *event);
    own_.append(seq, event);
}

Seq ClusterCore::safe(Instant now) {
    // Whoever says nothing promises nothing, though there may be no peer left to wait for.
    if (!speaking_.may_speak(now)) return watermark_.safe();
    const auto& peers = live_peers();
    // In no view there are no clients: whoever promised them something alone is not replaced. Who
    // is only silent is no member less before the next view says so.
    const auto may_live = [this](const LogId& member) {
        return member != own_.id() && !membership_.has_ended(member);
    };
    const bool is_left_alone = peers.empty() && (view_change_.is_stranded(membership_, logs_) ||
                                                 std::ranges::any_of(view().members, may_live));
    if (!is_in_view() || is_left_alone) return watermark_.safe();
    return watermark_.advance(own_.last(), peers, live_peers_.version());
}

void ClusterCore::forward(const MessagePtr& message, Outbox& out) const {
    for (const BrokerId peer : peer_sessions_.interest().interested_in(message->topic)) {
        out.push_back({peer, ForwardBatch{{message}}});
    }
}

void ClusterCore::on(Effects& effects, BrokerId, const ForwardBatch& batch) {
    for (const auto& message : batch.messages) {
        effects.broker.on_peer_message(effects.now, message, effects.clients);
    }
}

void ClusterCore::on(Effects& effects, BrokerId from, const LogBatch& batch) {
    // Only of peers whose beacons are known: anything else is of an earlier life.
    const auto log = logs_.find(batch.log);
    if (log == logs_.end() || (log->second.is_frozen() && from == batch.log.broker)) return;
    log->second.offer(batch.first_seq, batch.events);
    fetching_.on_events(effects, from, *log, batch.events.size());
    apply(effects, batch.log, log->second, 2 * batch.events.size(), answer_to(batch));
}

ClusterCore::Answer ClusterCore::answer_to(const LogBatch& batch) const {
    if (!batch.awaited) return Answer::with_the_beacon;
    // A view without its writer, or without us, tells nothing about who else answers.
    if (!view_change_.contains(own_.id()) || !view_change_.contains(batch.log)) {
        return Answer::at_once;
    }
    const bool is_asked =
        is_quick_holder(own_.id().broker, batch.log.broker, live_peers(), options_.acks);
    return is_asked ? Answer::at_once : Answer::with_the_beacon;
}

void ClusterCore::on(Effects&, BrokerId, const LogAck& ack) {
    if (ack.through.log != own_.id() || !membership_.is_alive(ack.by)) return;
    watermark_.on_ack(ack.by, ack.through.seq);
}

void ClusterCore::on(Effects& effects, BrokerId, const Fetch& fetch) {
    log_sender_.on_fetch(effects, fetch, logs(), membership_, departures_);
}

void ClusterCore::on(Effects& effects, BrokerId from, const SnapshotPart& part) {
    const LogId id = part.as_of.log;
    if (id.broker != from) return take_last_publishes(effects, from, part);
    const auto found = logs_.find(id);
    if (found == logs_.end() || found->second.is_frozen()) return;
    PeerLog& log = found->second;
    for (const auto& message : part.retained) effects.broker.put_retained(message);
    for (const auto& session : part.sessions) {
        for (const auto& delivery : session.deliveries) {
            const bool is_missing = log.mirror().is_unresolved(delivery.position);
            if (is_missing && delivery.message) learn(delivery.message);
        }
    }
    if (part.as_of.seq <= log.applied() || !log.offer(part)) return;
    fetching_.on_part(effects.now, id);
    publish_order_.on_snapshot(effects, part, logs_);
    for (const auto& message : part.publishes) learn(message);
    const bool is_first = log.applied() == 0;
    if (is_first) peer_sessions_.on_first_snapshot(part, log.replaced());
    const auto as_of = log.restart();
    if (!as_of) return;
    for (const LogPosition& position : log.mirror().unresolved()) {
        if (const auto message = logs().publish_at(position)) log.mirror().resolve(message);
    }
    note_lacking(id, log);
    if (!is_first) peer_sessions_.reset(id, log.mirror());
    publish_order_.on_snapshot_end(effects, *as_of);
    arrivals_.on_snapshot(effects, log);
    settlement_.compare();
    acknowledgements_.forget(id);
    log.mirror().visit([&](const broker::SessionImage& image) {
        mark_taken(image.header.client_id);
        acknowledgements_.on_session(id, as_of->seq, image, is_held());
    });
    apply(effects, id, log, options_.events_per_turn);
    acknowledge(effects, id, log);
}

/// Of a removed broker's log. Sessions that are on their way to us may lack them, too.
void ClusterCore::take_last_publishes(Effects& effects, BrokerId from, const SnapshotPart& part) {
    if (fetching_.on_last_publishes(effects.now, from, part)) {
        const auto log = logs_.find(part.as_of.log);
        if (log != logs_.end()) log->second.offer_ahead(part.publishes);
        for (const auto& message : part.publishes) publish_order_.on_publish(effects, message);
        if (part.last) publish_order_.on_snapshot_end(effects, part.as_of);
    }
    for (const auto& message : part.publishes) learn(message);
}

void ClusterCore::catch_up(Effects& effects) {
    publish_order_.allow(options_.events_per_turn);
    take_over_.on_turn();
    settlement_.compare_some(effects.broker, logs_, view());
    arrivals_.on_turn();
    say_again(effects);
    sessions_brought_.clear();
    for (const auto& [id, held_up] : std::exchange(behind_, {})) {
        const auto log = logs_.find(id);
        if (log != logs_.end()) apply(effects, id, log->second, options_.events_per_turn + held_up);
    }
}

void ClusterCore::apply(Effects& effects, const LogId& id, PeerLog& log, std::size_t most,
                        Answer answer) {
    const Seq before = log.applied();
    std::size_t& sessions = sessions_brought_[id];
    for (; most > 0 && log.has_next(); --most) {
        const bool is_counted = !log.is_frozen() && brings_session(*log.next());
        if (is_counted && ++sessions > options_.sessions_per_turn) break;
        apply_event(effects, id, log);
    }
    if (log.has_next()) behind_[id] += most;
    if (log.applied() == before) return;
    if (!log.is_frozen() && answer == Answer::at_once) acknowledge(effects, id, log);
    acknowledge_what_waited(effects);
}

void ClusterCore::acknowledge_what_waited(Effects& effects) {
    for (const LogId& id : acknowledgements_.advance(is_held())) {
        const PeerLog& log = logs_.at(id);
        if (!log.is_frozen()) acknowledge(effects, id, log);
    }
}

void ClusterCore::acknowledge(Effects& effects, const LogId& id, const PeerLog& log) const {
    effects.peers.push_back({id.broker, LogAck{{id, held_of(id, log)}, own_.id()}});
}

Seq ClusterCore::held_of(const LogId& id, const PeerLog& log) const {
    if (log.is_frozen()) return log.applied();
    return acknowledgements_.through(id, log.applied(), is_held());
}

Acknowledgements::IsHeld ClusterCore::is_held() const {
    return [this](const LogId& by, const LogPosition& publish) {
        const LogId& id = publish.log;
        if (id == own_.id()) return true;
        const auto log = logs_.find(id);
        if (view_change_.contains(id)) {
            return log != logs_.end() && log->second.holds(publish.seq);
        }
        // It ended before we came: the home that names it brings it (fetching.h).
        if (log == logs_.end()) return !logs_.at(by).mirror().is_unresolved(publish);
        if (log->second.holds(publish.seq)) return true;
        // I6: without a view, or back from a standstill, this broker does not know who is gone.
        if (!is_in_view() || is_back()) return false;
        // Of a removed log comes what the view agreed on, from the members that hold it.
        return log->second.is_frozen() ? !fetching_.awaits(publish) : !membership_.is_alive(id);
    };
}

void ClusterCore::apply_event(Effects& effects, const LogId& id, PeerLog& log) {
    const LogEventPtr next = log.next();
    const LogEvent& event = *next;
    const auto* put = std::get_if<broker::SessionPut>(&event);
    if (!log.is_frozen()) {
        if (const broker::ClientId* left = broker::leaver(event)) {
            const auto* session = log.session(*left);
            if (session != nullptr) roaming_.on_let_go(effects, *session);
        }
        peer_sessions_.on_event(effects.now, log.mirror(), event,
                                effects.broker.limits().half_a_queue());
    } else {
        peer_sessions_.on_late_event(id);
    }
    if (put != nullptr) publish_order_.on_session(effects, log, put->image, logs_, view());
    log.apply();
    arrivals_.on_event(effects, log, event);
    if (put != nullptr && put->adopted) on_arrived(put->image.header.client_id, *put->adopted);
    if (const auto* publish = std::get_if<broker::Published>(&event)) {
        effects.broker.observe_time(publish->message->published_at);
        take_over_.on_publish(publish->message->topic);
        publish_order_.on_publish(effects, publish->message);
        learn(publish->message);
    }
    const auto* routed = std::get_if<broker::Routed>(&event);
    if (routed != nullptr && log.mirror().is_unresolved(routed->message)) {
        MessagePtr message = logs().publish_at(routed->message);
        if (!message) message = effects.broker.retained_at(routed->message);
        if (message) log.mirror().resolve(message);
    }
    note_lacking(id, log);
    if (!log.is_frozen()) acknowledgements_.on_event(id, log.applied(), event, is_held());
    if (put != nullptr && !put->image.header.client_id.empty() && !log.is_frozen()) {
        const broker::ClientId& client = put->image.header.client_id;
        mark_taken(client);
        peer_sessions_.on_living_home(client, logs_);
        settlement_.on_peer_session(effects, id, client);
    }
    const auto* changed = std::get_if<broker::SessionChanged>(&event);
    if (changed != nullptr) settlement_.on_peer_session(effects, id, changed->header.client_id);
}

void ClusterCore::on_arrived(const broker::ClientId& client, const LogPosition& moved) {
    if (moved.log == own_.id()) return departures_.on_arrived(client, moved.seq);
    const auto log = logs_.find(moved.log);
    if (log != logs_.end()) log->second.on_arrived(client, moved.seq);
}

/// A peer is home to the client now: what the dead left of it is nobody's to adopt any more.
void ClusterCore::mark_taken(const broker::ClientId& client) {
    for (auto& [id, log] : logs_) log.mark_taken(client);
}

void ClusterCore::learn(const MessagePtr& message) {
    std::erase_if(lacking_, [&](const LogId& id) {
        const auto log = logs_.find(id);
        if (log == logs_.end()) return true;
        log->second.mirror().resolve(message);
        return !log->second.mirror().is_any_unresolved();
    });
}

void ClusterCore::note_lacking(const LogId& id, const PeerLog& log) {
    if (log.mirror().is_any_unresolved()) lacking_.insert(id);
}

void ClusterCore::trim(Effects& effects) {
    const auto expired =
        keeping_.expire(effects.now, effects.times, logs_, membership_, view_change_);
    for (const LogId& id : expired) {
        watermark_.forget(id);
        acknowledgements_.forget(id);
        peer_sessions_.forget(id);
        logs_.erase(id);
    }
    if (!expired.empty()) forget_old_lives(effects);
    keeping_.forget_passed(effects.now, effects.times, logs(), membership_, watermark_);
}

void ClusterCore::forget_old_lives(Effects& effects) {
    const auto are_over = [this](const LogId& id) { return is_over(id, logs(), membership_); };
    effects.broker.forget_logs(are_over, effects.clients);
    for (auto& [id, log] : logs_) log.mirror().forget_logs(are_over);
}

}  // namespace romano::cluster
