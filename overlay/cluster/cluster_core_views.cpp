// The agreement of ClusterCore: what beacons, ballots and views change, and what this broker says
// of itself.
#include <algorithm>
#include <iterator>
#include <utility>

#include "overlay/cluster/cluster_core.h"

namespace romano::cluster {

void ClusterCore::on(Effects& effects, BrokerId from, const Heartbeat& heartbeat) {
    if (heartbeat.log.broker != from) return;
    const auto heard = membership_.on_heartbeat(effects.now, heartbeat.log, [&](Beacon* last) {
        return peers_beacons_.read(heartbeat, last, view(), beacons_sent_);
    });
    if (peers_beacons_.must_ask(effects.now, effects.times.particulars_asked_again_after(), from)) {
        effects.peers.push_back({from, Particulars{.wanted = true}});
    }
    if (heard != Membership::Heard::nothing) heed(effects, membership_.find(from)->beacon, heard);
}

void ClusterCore::on(Effects& effects, BrokerId from, const Particulars& particulars) {
    if (particulars.wanted) {
        effects.peers.push_back({from, Particulars{beacon(effects.broker), settings_.own()}});
        return;
    }
    if (particulars.beacon.log.broker != from) return;
    settings_.on_told(from, particulars.settings);
    const Peer* peer = membership_.find(from);
    const bool is_known = peer != nullptr && peer->beacon.log == particulars.beacon.log;
    const auto beacon =
        peers_beacons_.read(particulars, is_known ? &peer->beacon : nullptr, view());
    if (!beacon) return;
    const auto heard = membership_.on_beacon(effects.now, *beacon);
    if (heard != Membership::Heard::nothing) heed(effects, *beacon, heard);
}

void ClusterCore::heed(Effects& effects, const Beacon& beacon, Membership::Heard heard) {
    lease_.on_heard(effects.now, beacon.log, beacon.tick);
    for (const Echo& echo : beacon.echoes) {
        if (echo.of == own_.id())
            lease_.on_echo(beacon.log, echo.tick, beacon.view.number, beacon.vouched);
    }
    if (is_back() && leaves_out(beacon)) arrivals_.forget_waiting(logs_);
    if (membership_.is_alive(beacon.log)) {
        heed_log_of(beacon);
        if (heard == Membership::Heard::news) ended_.learn(view(), beacon.ended);
        settings_.on_beacon(effects, beacon);
    }
    if (heard == Membership::Heard::news) heed_news_of_peers(effects);
}

void ClusterCore::on(Effects& effects, BrokerId, const Pulse& pulse) {
    membership_.on_pulse(effects.now, pulse);
}

void ClusterCore::heed_news_of_peers(Effects& effects) {
    if (!knows_its_place(effects.now)) return;
    compare_addresses(effects);
    view_change_.on_tick(effects.now, surroundings(effects), effects.peers);
}

void ClusterCore::heed_log_of(const Beacon& beacon) {
    const auto [at, is_new] = logs_.try_emplace(beacon.log, beacon.log, options_.log_events_kept);
    PeerLog& log = at->second;
    // A leader may have put it into the view before we hear it. Else it may be the log of one who
    // was replaced before we came, of whose sessions others took care.
    if (is_new && view_change_.contains(beacon.log)) {
        peer_sessions_.reset(beacon.log, log.mirror());
    } else if (is_new) {
        log.become_outdated();
    }
    acquaintance_.meet(beacon.log, beacon.last_seq);
    log.heard_end(beacon.last_seq, beacon.view.number);
    log.heard_serving(beacon.serving);
    log.set_foreign(beacon.predefined != predefined_);
    watermark_.on_beacon(beacon.log, beacon.held_of(own_.id()).value_or(0));
    if (!has_frozen_logs_) return;
    for (auto& [id, held] : logs_) {
        if (!held.is_frozen() || id.broker == beacon.log.broker) continue;
        for (const Endpoint& address : beacon.serving) held.mark_served(address);
    }
}

void ClusterCore::on(Effects& effects, BrokerId from, const ElectionMessage& message) {
    membership_.on_ballot(effects.now, from, message.ballot);
    heed_news_of_peers(effects);
}

void ClusterCore::on(Effects& effects, BrokerId, const ViewProposal& message) {
    membership_.on_leader(effects.now, message.view.number.leader, message.view.number.term);
    view_change_.on_proposal(effects.now, message, surroundings(effects), effects.peers);
}

void ClusterCore::on(Effects& effects, BrokerId from, const ViewHoldings& message) {
    const Peer* peer = membership_.find(from);
    if (peer == nullptr) return;
    view_change_.on_holdings(effects.now, peer->beacon.log, message, surroundings(effects),
                             effects.peers);
}

void ClusterCore::on(Effects& effects, BrokerId, const ViewAnnouncement& message) {
    membership_.on_leader(effects.now, message.view.number.leader, message.view.number.term);
    view_change_.on_announcement(effects.now, message, surroundings(effects));
}

void ClusterCore::take_view(Effects& effects) {
    if (const auto installed = view_change_.take_installed()) on_view(effects, *installed);
}

void ClusterCore::on_view(Effects& effects, const ViewAnnouncement& announcement) {
    ++views_seen_;
    const BrokerId leader = view().number.leader;
    effects.local.push_back(
        Notice{"view " + std::to_string(view().number.term) + " of " +
               std::to_string(view().members.size()) + ", led by " +
               (leader == own_.id().broker ? name_ : membership_.name_of(leader))});
    ended_.on_view(view(), announcement.ends);
    for (const auto& [id, peer] : membership_.peers()) {
        if (peer.alive) ended_.learn(view(), peer.beacon.ended);
    }
    // An heir whose own detector is a little slower must not take the dead for a rival, and fall
    // silent, at the very moment at which it takes the address over.
    for (const LogPosition& end : announcement.ends) membership_.on_left_out(effects.now, end.log);
    // It may have bound its address beside us, and stopped and not died: datagrams would go there,
    // and what clients answered until now did.
    for (const LogPosition& end : announcement.ends) {
        const Peer* peer = membership_.find(end.log.broker);
        if (peer == nullptr || peer->beacon.log != end.log) continue;
        for (const Endpoint& address : addresses_.serving()) {
            if (!peer->is_home_of(address)) continue;
            addresses_.take_anew(effects, address);
            said_again_.insert_or_assign(address, 0);
        }
    }
    for (const auto& [id, log] : logs_) {
        if (!log.is_frozen()) continue;
        peer_sessions_.on_end(id);
        arrivals_.on_end(effects, log);
    }
    for (const LogId& member : view().members) {
        const auto log = logs_.find(member);
        if (log != logs_.end() && !peer_sessions_.follow(member)) {
            peer_sessions_.reset(member, log->second.mirror());
        }
    }
    smaller_side_.on_view(effects.now, view(), [this](const LogId& member) {
        return member.broker == own_.id().broker || membership_.has_ended(member);
    });
    acquaintance_.on_view(effects.now, effects.times, own_.id(), view(), lease_.was_held_before(),
                          logs_);
    // Other members hand us what our earlier lives left at our address, if it has not been done
    // yet.
    std::map<Endpoint, std::set<LogId>> givers;
    for (const Assignment& assignment : announcement.assignments) {
        const Endpoint& address = assignment.address;
        // Unless that serves the address in its own cell: then the sessions are at home there.
        const Peer* heir = membership_.find(assignment.heir);
        if (heir != nullptr && heir->is_home_of(address)) continue;
        const auto life = std::ranges::find(view().members, assignment.heir, &LogId::broker);
        if (life == view().members.end() || *life == own_.id()) continue;
        if (!addresses_.is_home(address) || !addresses_.is_serving(address)) continue;
        // One with sessions of its own there may not say that it waits: a rival would speak (I1).
        if (hand_back_.is_binding(address) || !effects.broker.is_home_of_any_via(address)) {
            givers[address].insert(*life);
        }
    }
    for (auto& [address, heirs] : givers) {
        hand_back_.expect(effects.now, address, std::move(heirs));
    }
    warn_of_foreign_sessions(effects, announcement);
    take_over_.on_view(effects.now, announcement, addresses_);
    fetching_.on_view(announcement);
    acknowledge_what_waited(effects);
    settlement_.compare();
    // Before anything is said in this view.
    settlement_.compare_some(effects.broker, logs_, view());
}

/// Nobody goes on for those whom only brokers with other predefined topics survive. Told once, and
/// not in each view.
void ClusterCore::warn_of_foreign_sessions(Effects& effects, const ViewAnnouncement& announcement) {
    std::erase_if(without_heir_, [this](const LogId& id) { return !logs_.contains(id); });
    for (const LogPosition& end : announcement.ends) {
        const auto log = logs_.find(end.log);
        if (log == logs_.end() || !log->second.is_foreign()) continue;
        const bool has_heir = std::ranges::any_of(
            announcement.assignments,
            [&](const Assignment& assignment) { return assignment.end.log == end.log; });
        if (has_heir || log->second.addresses_left(view()).empty()) {
            without_heir_.erase(end.log);
            continue;
        }
        if (!without_heir_.insert(end.log).second) continue;
        effects.local.push_back(Notice{.text = "nobody goes on for the clients of " +
                                               membership_.name_of(end.log.broker) +
                                               ": no broker with its predefined topics is left",
                                       .is_warning = true});
    }
}

bool ClusterCore::leaves_out(const Beacon& beacon) const {
    return view_change_.contains(beacon.log) && beacon.view.number > view().number &&
           !beacon.view.contains(own_.id());
}

void ClusterCore::heed_standstill(Instant now) {
    if (!is_back() || !lease_.is_held(now)) return;
    // Whoever moves sessions takes them back after ten detection times; then they live on there.
    if (stood_still_for_ > times().waiting_handover_outlives()) arrivals_.forget_waiting(logs_);
    stood_still_for_ = {};
}

/// After a standstill: once somebody was heard since, and everybody who was has said who is in its
/// view and which logs have ended; or had the time for it.
bool ClusterCore::knows_its_place(Instant now) const {
    if (!is_back() || lease_.is_held(now)) return true;
    if (was_replaced(now)) return false;
    if (lease_.has_waited(now)) return true;
    bool has_heard = false;
    for (const auto& [id, peer] : membership_.peers()) {
        const bool is_fresh = !lease_.may_be_outdated(peer.beacon.log);
        if (is_fresh ? !peers_beacons_.is_complete(id) : membership_.is_heard(id)) return false;
        has_heard |= is_fresh;
    }
    return has_heard;
}

bool ClusterCore::was_replaced(Instant now) const {
    if (!is_back() || lease_.is_held(now)) return false;
    return std::ranges::any_of(membership_.peers(), [this](const auto& entry) {
        const Beacon& beacon = entry.second.beacon;
        if (const auto end = beacon.end_of(own_.id())) return *end >= watermark_.safe();
        return leaves_out(beacon) && !watermark_.has_promised_alone();
    });
}

bool ClusterCore::notice_standstill(Instant now) {
    const auto away = lease_.notice_standstill(now);
    if (!away) return false;
    stood_still_for_ = std::max(stood_still_for_, *away);
    view_change_.on_standstill();
    roaming_.on_standstill(now);
    return true;
}

Surroundings ClusterCore::surroundings(const Effects& effects) {
    return {.membership = membership_,
            .lease = lease_,
            .logs = logs_,
            .addresses = addresses_,
            .ended = ended_,
            .sessions = static_cast<std::uint32_t>(effects.broker.session_count())};
}

bool ClusterCore::is_short_of_peers() const {
    if (!options_.acks_strict) return false;
    return live_peers().size() < (options_.acks == all_peers ? 1 : options_.acks);
}

const std::vector<LogId>& ClusterCore::live_peers() const {
    return live_peers_.of(view(), membership_);
}

Beacon ClusterCore::beacon(const broker::BrokerCore& broker) const {
    Beacon beacon{.name = name_,
                  .log = own_.id(),
                  .last_seq = broker.last_seq(),  // with what this turn wrote
                  .tick = beacons_sent_,
                  .view = view(),
                  .promised = promised(),
                  .ended = ended_.list(),
                  .home_addresses = addresses_.home(),
                  .binding = hand_back_.binding(),
                  .sessions = static_cast<std::uint32_t>(broker.session_count()),
                  .connected = static_cast<std::uint32_t>(broker.connected_count()),
                  .cannot_take = static_cast<std::uint32_t>(addresses_.cannot_take().size()),
                  .usage = usage_,
                  .link = link_,
                  .settings = settings_.digest(),
                  .predefined = predefined_};
    std::ranges::copy_if(addresses_.claimed(), std::back_inserter(beacon.serving),
                         [this](const Endpoint& it) { return !hand_back_.is_reclaiming(it); });
    membership_.describe(beacon);
    beacon.echoes = lease_.echoes();
    beacon.applied.reserve(logs_.size());
    for (const auto& [id, log] : logs_) beacon.applied.push_back({id, held_of(id, log)});
    return beacon;
}

void ClusterCore::send_beacon(Effects& effects) {
    lease_.on_beat(effects.now, ++beacons_sent_);
    last_leadership_ = leadership();
    last_view_ = view().number;
    own_.accompany_beacon();
    Beacon next = beacon(effects.broker);
    next.vouched = lease_.vouched(effects.now);
    say(effects, next);
}

void ClusterCore::say(Effects& effects, const Beacon& beacon) {
    const Heartbeat heartbeat = heartbeats_.write(beacon);
    if (heartbeats_.has_news()) {
        for (const auto& [id, peer] : membership_.peers()) {
            if (!membership_.is_heard(id)) continue;
            effects.peers.push_back({id, Particulars{beacon, settings_.own()}});
        }
    }
    effects.peers.push_back({std::nullopt, heartbeat});
}

void ClusterCore::leave(Effects effects) {
    ++beacons_sent_;
    own_.accompany_beacon();
    Beacon last = beacon(effects.broker);
    last.leaving = true;
    say(effects, last);
}

void ClusterCore::restart(Effects effects, LogId log) {
    own_ = OwnLog(log, options_.log_events_kept);
    stood_still_for_ = {};
    membership_.restart();
    watermark_ = Watermark(options_.acks);
    acknowledgements_ = {};
    said_again_.clear();
    lease_.restart(log);
    view_change_.restart(log);
    acquaintance_ = {};
    smaller_side_ = {};
    take_over_.restart();
    fetching_ = Fetching(log.broker);
    hand_back_ = HandBack(log.broker, options_.sessions_per_turn);
    compared_.reset();
    strays_ = Strays(options_.sessions_per_turn);
    arrivals_ = Arrivals(log, options_.sessions_per_turn);
    departures_ = Departures(options_.sessions_per_turn);
    settlement_ = Settlement(log.broker, options_.sessions_per_turn);
    roaming_ = Roaming(predefined_);
    log_sender_ = {};
    addresses_.give_up_all(effects);
    publish_order_.release_all(effects);
    for (auto& [id, held] : logs_) {
        held.become_outdated();
        effects.broker.advance_cursor({id, held.applied()});
    }
}

}  // namespace romano::cluster
