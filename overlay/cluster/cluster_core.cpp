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
      strays_(options.sessions_per_turn),
      arrivals_(identity.log, options.sessions_per_turn),
      departures_(options.sessions_per_turn),
      speaking_({.views = view_change_,
                 .acquaintance = acquaintance_,
                 .lease = lease_,
                 .take_over = take_over_,
                 .hand_back = hand_back_,
                 .departures = departures_,
                 .addresses = addresses_}),
      settlement_(identity.log.broker, options.sessions_per_turn),
      roaming_(digest_of(identity.predefined)),
      predefined_(digest_of(identity.predefined)),
      settings_(identity.name, agreed_settings(options, identity.predefined)) {
    due_.fill(Instant::min());
}

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

void ClusterCore::on_message(Effects effects, const Envelope& envelope) {
    const BrokerId from = envelope.from.broker;
    if (from == own_.id().broker) {
        if (auto notice = namesake_.on_message(effects.now, effects.times.namesake_told_every(),
                                               name_, link_.process, envelope.from.incarnation)) {
            effects.local.push_back(*std::move(notice));
        }
        return;
    }
    if (is_for_later(effects.now, envelope.message)) return;
    std::visit([&](const auto& message) { on(effects, from, message); }, envelope.message);
    after_input(effects);
}

void ClusterCore::on_tick(Effects effects, const std::set<Endpoint>& pending_output) {
    // Before the broker writes more events.
    log_sender_.carry_on(effects, logs(), membership_, departures_);
    peer_sessions_.on_turn();
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
        strays_.carry_on(effects, logs(), membership_, view(), addresses_, departures_,
                         take_over_.half_adopted());
        departures_.carry_on(effects, logs(), view());
    }
    catch_up(effects);
    after_input(effects);
    // What is due earlier waits for the beacon: one wake-up for all.
    if (effects.now < due_at(Timer::beacon)) return;
    for (std::size_t i = 0; i < due_.size(); ++i) {
        if (effects.now >= due_[i]) due_[i] = effects.now + on_timer(effects, Timer{i});
    }
}

Duration ClusterCore::on_timer(Effects& effects, Timer timer) {
    const Times& times = effects.times;
    switch (timer) {
        case Timer::cursors:
            effects.broker.append_cursors(effects.clients);
            return times.cursors_told_every();
        case Timer::trim:
            trim(effects);
            return keeping_.is_behind() ? times.beacon_every : times.logs_trimmed_every();
        case Timer::forget_moved:
            for (auto& [id, log] : logs_) log.forget_moved();
            return times.moved_sessions_kept_for();
        case Timer::seek_addresses:
            seek_addresses(effects);
            return times.addresses_sought_every();
        case Timer::beacon:
            warn_when_leaderless(effects);
            send_beacon(effects);
            return times.beacon_every;
    }
    return times.beacon_every;
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
    const bool moves_some =
        hand_back_.is_half_done(departures_) || !take_over_.half_adopted().empty();
    const bool is_half_done = is_behind() || (moves_some && !is_back());
    if (is_half_done) return Instant::min();
    return std::min({due_at(Timer::beacon), membership_.next_wakeup(), log_sender_.next_wakeup(),
                     view_change_.next_wakeup()});
}

bool ClusterCore::is_behind() const {
    const bool are_half_done =
        arrivals_.is_half_done() || departures_.is_half_done() || settlement_.is_half_done();
    return publish_order_.is_behind() || (are_half_done && !is_back()) || !said_again_.empty() ||
           !behind_.empty();
}

bool ClusterCore::may_rest() const {
    if (is_behind() || hand_back_.is_awaited()) return false;
    return take_over_.half_adopted().empty() ? hand_back_.is_half_done(departures_)
                                             : take_over_.may_rest();
}

/// While nobody else serves them, only news change that.
void ClusterCore::compare_addresses(Effects& effects) {
    const std::tuple now{membership_.news(), view().number, addresses_.serving()};
    if (!hand_back_.has_rivals() && now == compared_) return;
    compared_ = now;
    hand_back_.compare(effects, membership_, view(), addresses_);
}

void ClusterCore::seek_addresses(Effects& effects) {
    const auto is_held = [&](const Endpoint& address) {
        return take_over_.is_left_to_another(address) ||
               std::ranges::any_of(membership_.peers(), [&](const auto& entry) {
                   return entry.second.alive && entry.second.is_serving(address);
               });
    };
    addresses_.seek(effects, is_held);
    // Whom we have not met may serve it.
    if (!is_in_view() || !acquaintance_.has_met_all()) return;
    for (const Endpoint& address : addresses_.home()) {
        if (!is_held(address)) addresses_.take(effects, address);
    }
}

void ClusterCore::hurry(Effects effects, const Endpoint& via, const Endpoint& from,
                        Bytes datagram) {
    if (!speaking_.may_speak(effects.now) || !is_in_view() || !acquaintance_.has_met_all()) return;
    if (take_over_.is_half_adopted(via)) {
        const auto client =
            roaming_.client_of({via, from}, datagram, effects.broker, peer_sessions_.homes());
        if (client) take_over_.on_client(*client);
    } else if (hand_back_.is_expecting(via) && !speaking_.is_silent(via)) {
        (void)must_fetch(effects, via, from, datagram);
    }
}

bool ClusterCore::must_fetch(Effects effects, const Endpoint& via, const Endpoint& from,
                             Bytes datagram) {
    return is_fetching(via, from) ||
           roaming_.on_datagram(effects, {via, from}, datagram, peer_sessions_.homes(), departures_,
                                membership_, view());
}

void ClusterCore::on_address(Effects effects, const Endpoint& address, bool served) {
    addresses_.on_address(address, served);
    hand_back_.on_address(effects.now, address, served);
    compare_addresses(effects);  // before anything is said there
    after_input(effects);
}

void ClusterCore::on_link(Effects effects, const LogId& process, election::Link link) {
    if (!membership_.on_link(effects.now, process, link)) return;
    heed_news_of_peers(effects);
    after_input(effects);
}

void ClusterCore::on_condition(Effects effects, std::uint32_t reading) {
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
    if (knows_its_place(effects.now)) {
        take_over_.carry_on(effects, logs(), membership_, view(), addresses_, departures_,
                            promised() == view().number);
    }
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
        if (speaking_.is_silent(address)) {
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
        if (speaking_.is_silent(address) || !addresses_.is_serving(address)) continue;
        const auto next = effects.broker.send_again(effects.now, address, from,
                                                    options_.sessions_per_turn, effects.clients);
        if (next) left.emplace(address, *next);
    }
    said_again_ = std::move(left);
}

// --- sessions and addresses that move

/// Clients would wait here for those whom we have not met.
void ClusterCore::reclaim(Effects& effects) {
    const bool may_serve = acquaintance_.has_met_all() && !acquaintance_.may_roam();
    if (may_serve && speaking_.may_speak(effects.now)) {
        hand_back_.reclaim(effects, membership_, view(), addresses_);
    }
}

void ClusterCore::heed_arrivals(Effects& effects) {
    if (is_back()) return;
    arrivals_.heed(effects.now, [&](const LogPosition& position) {
        return publish_order_.is_worked_through(effects, position, logs_, view());
    });
    const auto settled = arrivals_.carry_on(
        effects, logs(),
        [this](const auto& comes) { return settlement_.home_of_higher(comes, logs_, membership_); },
        departures_);
    for (const auto& [from, address] : settled) {
        hand_back_.on_handed_over(from, address);
        take_over_.on_handed_over(from, address);
        // It may have been handed on while they were on their way: they follow it.
        if (address.family != Endpoint::Family::none) addresses_.take(effects, address);
    }
}

void ClusterCore::on(Effects& effects, BrokerId from, const SessionRequest& request) {
    const Peer* peer = membership_.find(from);
    const broker::SessionHeader* own = effects.broker.header(request.client_id);
    if (peer == nullptr || own == nullptr) return;
    // The peer hears the client at an address that is served here, so the address goes back: what
    // the client was answered leaves first.
    const bool is_handed_back =
        request.at == own->via && addresses_.is_serving(own->via) && !addresses_.is_home(own->via);
    if (is_handed_back) return hand_back_.on_awaited(*own);
    if (speaking_.is_silent(own->via)) return;
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
