#include "overlay/cluster/cluster_core.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace romano::cluster {

ClusterCore::ClusterCore(const ClusterOptions& options, const Identity& identity,
                         std::uint64_t seed)
    : options_(options),
      name_(identity.name),
      link_(identity.link),
      own_(identity.log, options.log_events_kept),
      peers_beacons_(identity.log.broker),
      membership_(options, identity.log.broker, seed),
      addresses_(identity.home_addresses),
      publish_order_(identity.log.broker),
      watermark_(options.acks),
      lease_(identity.log, options.beacon_every, options.detection_timeout),
      view_change_(identity.log),
      take_over_(identity.log.broker, options.sessions_per_turn),
      fetching_(identity.log.broker),
      hand_back_(identity.log.broker, options.sessions_per_turn),
      arrivals_(identity.log, options.sessions_per_turn),
      departures_(options.sessions_per_turn),
      settlement_(identity.log.broker, options.sessions_per_turn),
      roaming_(digest_of(identity.predefined)),
      predefined_(digest_of(identity.predefined)),
      settings_(identity.name, agreed_settings(options, identity.predefined)) {}

// --- inputs

/// Who is in the view, and whose are addresses and sessions, is not decided before we know our
/// place. What is asked for comes again.
bool ClusterCore::is_for_later(Instant now, const ClusterMessage& message) const {
    if (knows_its_place(now)) return false;
    if (const auto* announcement = std::get_if<ViewAnnouncement>(&message)) {
        return !view_change_.is_promised_anew(announcement->view);
    }
    return std::holds_alternative<ViewProposal>(message) ||
           std::holds_alternative<ViewHoldings>(message) ||
           std::holds_alternative<SessionRequest>(message);
}

void ClusterCore::on_message(Effects& effects, const Envelope& envelope) {
    const BrokerId from = envelope.from.broker;
    if (from == own_.id().broker) {
        if (auto notice = namesake_.on_message(name_, link_.process, envelope.from.incarnation)) {
            effects.local.push_back(*std::move(notice));
        }
        return;
    }
    if (is_for_later(effects.now, envelope.message)) return;
    std::visit([&](const auto& message) { on(effects, from, message); }, envelope.message);
    after_input(effects);
}

void ClusterCore::on_tick(Effects& effects, const std::set<Endpoint>& pending_output) {
    // Before the broker writes more events.
    log_sender_.carry_on(effects, logs(), membership_, departures_);
    membership_.on_tick(effects.now);
    has_frozen_logs_ =
        std::ranges::any_of(logs_, [](const auto& log) { return log.second.is_frozen(); });
    if (knows_its_place(effects.now)) {
        view_change_.on_tick(effects.now, surroundings(effects), effects.peers);
        take_view(effects);
        compare_addresses(effects);
        reclaim(effects);
        hand_back_.carry_on(effects, logs(), membership_, view(), addresses_, departures_,
                            {.pending_output = pending_output,
                             .half_adopted = take_over_.half_adopted(),
                             .inheriting = take_over_.inheriting()});
        departures_.carry_on(effects, logs(), view());
    }
    catch_up(effects);
    after_input(effects);
    if (effects.now < next_tick_) return;
    next_tick_ = effects.now + options_.beacon_every;
    if (effects.now >= next_cursors_) {
        next_cursors_ = effects.now + effects.times.cursors_told_every();
        effects.broker.append_cursors(effects.clients);
    }
    if (effects.now >= next_trim_) {
        trim(effects);
        next_trim_ = effects.now + (keeping_.is_behind() ? effects.times.beacon_every
                                                         : effects.times.logs_trimmed_every());
    }
    if (effects.now >= next_moved_) {
        next_moved_ = effects.now + effects.times.moved_sessions_kept_for();
        for (auto& [id, log] : logs_) log.forget_moved();
    }
    if (effects.now >= next_addresses_) {
        next_addresses_ = effects.now + effects.times.addresses_sought_every();
        seek_addresses(effects);
    }
    warn_when_leaderless(effects);
    send_beacon(effects);
}

void ClusterCore::warn_when_leaderless(Effects& effects) {
    const bool is_led = is_in_view() && leadership().leader.has_value();
    const Duration patience = effects.times.leaderless_told_every();
    if (!leaderless_.is_to_be_told(effects.now, patience, is_led)) return;
    std::vector<std::string> heard;
    for (const auto& [id, peer] : membership_.peers()) {
        if (peer.alive) heard.push_back(membership_.name_of(id));
    }
    effects.local.push_back(leaderless_notice(patience, heard, options_));
}

Instant ClusterCore::next_wakeup() const {
    const bool is_behind = publish_order_.is_behind() || (arrivals_.is_half_done() && !is_back()) ||
                           departures_.is_half_done() || hand_back_.is_half_done() ||
                           (settlement_.is_half_done() && !is_back()) ||
                           !take_over_.half_adopted().empty() || !said_again_.empty() ||
                           !behind_.empty();
    if (is_behind) return Instant::min();
    return std::min({next_tick_, membership_.next_wakeup(), log_sender_.next_wakeup(),
                     view_change_.next_wakeup()});
}

/// While nobody else serves them, only news change that.
void ClusterCore::compare_addresses(Effects& effects) {
    const Compared now{membership_.news(), view().number, view().members.size(),
                       addresses_.serving()};
    if (!hand_back_.has_rivals() && now == compared_) return;
    compared_ = now;
    hand_back_.compare(effects, membership_, view(), addresses_);
}

void ClusterCore::seek_addresses(Effects& effects) {
    for (const Endpoint& address : addresses_.missing()) addresses_.take(effects, address);
    if (!is_in_view()) return;
    for (const Endpoint& address : addresses_.home()) {
        const bool is_held = std::ranges::any_of(membership_.peers(), [&](const auto& entry) {
            return entry.second.alive && entry.second.is_serving(address);
        });
        if (!is_held) addresses_.take(effects, address);
    }
}

bool ClusterCore::must_wait(const Endpoint& via, const Endpoint& from) const {
    return !is_in_view() || !acquaintance_.has_met_all() || take_over_.is_half_adopted(via) ||
           hand_back_.is_expecting(via) || departures_.is_leaving(from);
}

bool ClusterCore::must_fetch(Effects& effects, const Endpoint& via, const Endpoint& from,
                             Bytes datagram) {
    return is_fetching(via, from) ||
           roaming_.on_datagram(effects, {via, from}, datagram, peer_sessions_.homes(), departures_,
                                membership_, view());
}

void ClusterCore::on_address(Effects& effects, const Endpoint& address, bool served) {
    addresses_.on_address(address, served);
    hand_back_.on_address(effects.now, address, served);
    compare_addresses(effects);  // before anything is said there
    after_input(effects);
}

void ClusterCore::on_link(Effects& effects, const LogId& process, election::Link link) {
    if (!membership_.on_link(effects.now, process, link)) return;
    heed_news_of_peers(effects);
    after_input(effects);
}

void ClusterCore::on_condition(Effects& effects, std::uint32_t reading) {
    membership_.on_condition(effects.now, reading);
    after_input(effects);
}

void ClusterCore::after_input(Effects& effects) {
    for (const BrokerId lost : membership_.take_lost()) {
        effects.local.push_back(Notice{"lost " + membership_.name_of(lost)});
    }
    heed_standstill(effects.now);
    heed_silence();
    take_view(effects);
    acquaintance_.carry_on(effects.now, logs_, [this](const LogId& member) {
        return membership_.is_heard(member) && peers_beacons_.is_complete(member.broker);
    });
    membership_.send_ballots(effects.peers);
    take_over_.carry_on(effects, logs(), membership_, view(), addresses_, departures_);
    fetching_.carry_on(effects, logs_, membership_, view(),
                       [this](const LogId& log) { return take_over_.awaits(log); });
    publish_order_.carry_on(effects, logs_, view());
    heed_arrivals(effects);
    roaming_.carry_on(effects, logs(), peer_sessions_.homes(), arrivals_, departures_, membership_,
                      view());
    heed_silence();
    if (knows_its_place(effects.now)) {
        settlement_.carry_on(effects, logs_, membership_, hand_back_, departures_);
    }
    // Others wait for these news.
    const bool news = leadership() != last_leadership_ || view().number != last_view_;
    if (news) send_beacon(effects);
}

void ClusterCore::heed_silence() {
    for (const Endpoint& address : addresses_.serving()) {
        if (hand_back_.is_silent(address)) {
            silent_.insert(address);
        } else if (silent_.erase(address) != 0) {
            said_again_.insert_or_assign(address, 0);
            settlement_.look_again();
        }
    }
}

void ClusterCore::say_again(Effects& effects) {
    std::map<Endpoint, std::uint32_t> left;
    for (const auto& [address, from] : said_again_) {
        if (hand_back_.is_silent(address) || !addresses_.is_serving(address)) continue;
        const auto next = effects.broker.send_again(effects.now, address, from,
                                                    options_.sessions_per_turn, effects.clients);
        if (next) left.emplace(address, *next);
    }
    said_again_ = std::move(left);
}

// --- membership and views

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
    PeerLog& log = log_of(beacon.log);
    acquaintance_.meet(beacon.log, beacon.last_seq);
    log.heard_end(beacon.last_seq, beacon.view.number);
    log.heard_serving(beacon.serving);
    log.set_foreign(beacon.predefined != predefined_);
    const auto own_held = beacon.held_of(own_.id());
    if (own_held) log.heard_by_writer();
    watermark_.on_beacon(beacon.log, own_held.value_or(0));
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

void ClusterCore::heed_leader(Instant now, const ViewNumber& number) {
    membership_.on_leader(now, number.leader, number.term);
}

void ClusterCore::on(Effects& effects, BrokerId, const ViewProposal& message) {
    heed_leader(effects.now, message.view.number);
    view_change_.on_proposal(effects.now, message, surroundings(effects), effects.peers);
}

void ClusterCore::on(Effects& effects, BrokerId from, const ViewHoldings& message) {
    const Peer* peer = membership_.find(from);
    if (peer == nullptr) return;
    view_change_.on_holdings(effects.now, peer->beacon.log, message, surroundings(effects),
                             effects.peers);
}

void ClusterCore::on(Effects& effects, BrokerId, const ViewAnnouncement& message) {
    heed_leader(effects.now, message.view.number);
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
    // It may have bound its address beside us, and stopped and not died: datagrams would go there.
    for (const LogPosition& end : announcement.ends) {
        const Peer* peer = membership_.find(end.log.broker);
        if (peer == nullptr || peer->beacon.log != end.log) continue;
        for (const Endpoint& address : addresses_.serving()) {
            if (peer->is_home_of(address)) addresses_.take_anew(effects, address);
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
    std::map<Endpoint, std::set<BrokerId>> givers;
    for (const Assignment& assignment : announcement.assignments) {
        const Endpoint& address = assignment.address;
        // Unless that serves the address in its own cell: then the sessions are at home there.
        const Peer* heir = membership_.find(assignment.heir);
        if (heir != nullptr && heir->is_home_of(address)) continue;
        if (assignment.heir != own_.id().broker && addresses_.is_home(address) &&
            addresses_.is_serving(address) && !effects.broker.is_home_of_any_via(address)) {
            givers[address].insert(assignment.heir);
        }
    }
    for (auto& [address, heirs] : givers) {
        hand_back_.expect(effects.now, address, std::move(heirs));
    }
    warn_of_foreign_sessions(effects, announcement);
    take_over_.on_view(effects.now, announcement);
    fetching_.on_view(announcement);
    acknowledge_what_waited(effects);
    settlement_.compare(view());
    settlement_.compare_some(effects.broker, logs_);  // before anything is said in this view
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
    claimed_ = addresses_.claimed();
    told_ends_ = ended_.list();
    cannot_take_ = addresses_.cannot_take();
    return {.membership = membership_,
            .lease = lease_,
            .logs = logs_,
            .serving = claimed_,
            .home = addresses_.home(),
            .cannot_take = cannot_take_,
            .ended = told_ends_,
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
                  .transport_octets_sent = octets_sent_,
                  .transport_octets_received = octets_received_,
                  .longest_turn_us = longest_turn_us_,
                  .cpu_percent = cpu_percent_,
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

void ClusterCore::leave(Effects& effects) {
    ++beacons_sent_;
    own_.accompany_beacon();
    Beacon last = beacon(effects.broker);
    last.leaving = true;
    say(effects, last);
}

void ClusterCore::restart(Effects& effects, LogId log) {
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
    arrivals_ = Arrivals(log, options_.sessions_per_turn);
    departures_ = Departures(options_.sessions_per_turn);
    settlement_ = Settlement(log.broker, options_.sessions_per_turn);
    roaming_ = Roaming(predefined_);
    log_sender_ = {};
    for (const Endpoint& address : addresses_.claimed()) addresses_.give_up(effects, address);
    publish_order_.release_all(effects);
    for (auto& [id, held] : logs_) {
        held.become_outdated();
        effects.broker.advance_cursor({id, held.applied()});
    }
}

// --- sessions and addresses that move

/// Clients would wait here for those whom we have not met.
void ClusterCore::reclaim(Effects& effects) {
    const bool may_serve = acquaintance_.has_met_all() && !strangers_may_roam();
    if (may_serve && may_speak(effects.now)) {
        hand_back_.reclaim(effects, membership_, view(), addresses_);
    }
}

void ClusterCore::heed_arrivals(Effects& effects) {
    if (is_back()) return;
    arrivals_.heed(effects.now, [&](const LogPosition& position) {
        return publish_order_.is_worked_through(effects, position, logs_, view());
    });
    arrivals_.carry_on(
        effects, logs(),
        [this](const auto& comes) { return settlement_.home_of_higher(comes, logs_, membership_); },
        departures_);
    for (const auto& [from, address] : arrivals_.take_settled()) {
        hand_back_.on_handed_over(from, address);
        // It may have been handed on while they were on their way: they follow it.
        if (address.family != Endpoint::Family::none) addresses_.take(effects, address);
    }
}

void ClusterCore::on(Effects& effects, BrokerId from, const SessionRequest& request) {
    const Peer* peer = membership_.find(from);
    const broker::SessionHeader* own = effects.broker.header(request.client_id);
    if (peer == nullptr || own == nullptr || hand_back_.is_silent(own->via)) return;
    roaming_.on_let_go(effects, *own);
    departures_.move(effects, request.client_id, peer->beacon.log, 1, logs_);
}

void ClusterCore::check_invariants([[maybe_unused]] const broker::BrokerCore& broker) const {
    assert(broker.last_seq() == own_.last() && "every event of the broker is in the log");
    assert(watermark_.safe() <= own_.last());
    assert(std::ranges::is_sorted(view().members));
    assert(view().members.empty() || view_change_.contains(own_.id()));
    assert(!logs_.contains(own_.id()));
    for ([[maybe_unused]] const auto& [id, log] : logs_) {
        assert((!log.has_next() || !log.is_frozen()) && "what is agreed on waits for nothing");
        assert(log.mirror().applied() == log.applied());
    }
}

}  // namespace romano::cluster
