#include "overlay/cluster/agreement/membership.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace romano::cluster {
namespace {

// Peers that are gone are remembered for their addresses; beyond this many the dead are forgotten.
constexpr std::size_t peers_known = 1'000;

}  // namespace

Membership::Membership(const ClusterOptions& options, BrokerId self, std::uint64_t seed)
    : options_(options), self_(self), seed_(seed) {
    const election::DetectorOptions times{.beacon_every = options.beacon_every,
                                          .timeout = options.detection_timeout,
                                          .phi_threshold = options.phi_threshold};
    heard_ = election::make_detector(options.detector, times);
    linked_ = election::make_detector(options.detector, times);
    assert(linked_ != nullptr && "the shell checks the detector's name");
    restart();
}

void Membership::restart() {
    std::vector<election::NodeId> voters;
    for (const auto& name : options_.voters) voters.push_back(node_of(broker::broker_id_of(name)));
    elector_ = election::make_elector(options_.elector,
                                      {.self = {.capability = options_.rank,
                                                .condition = condition_.told(),
                                                .id = node_of(self_)},
                                       .detection_time = linked_->detection_time(),
                                       .listens_alone_for = times().lone_newcomer_leads_after(),
                                       .voters = std::move(voters),
                                       .seed = ++seed_});
    assert(elector_ != nullptr && "the shell checks the elector's name");
}

Membership::Heard Membership::on_beacon(Instant now, const Beacon& beacon) {
    const BrokerId id = beacon.log.broker;
    if (id == self_) return Heard::nothing;
    if (!peers_.contains(id) && peers_.size() >= peers_known) {
        std::erase_if(peers_, [](const auto& entry) { return !entry.second.alive; });
        ++news_;
        if (peers_.size() >= peers_known) return Heard::nothing;
    }
    Peer& peer = peers_[id];
    if (beacon.log.incarnation < peer.beacon.log.incarnation) return Heard::nothing;
    const bool is_same_life = beacon.log == peer.beacon.log;
    if (is_same_life && beacon.tick < peer.beacon.tick) return Heard::nothing;
    const bool has_news = is_news(peer.beacon, beacon) || news_of(peer.beacon) != news_of(beacon);
    const bool is_new_tick = !is_same_life || beacon.tick > peer.beacon.tick;
    if (!is_same_life) {
        ++changes_;
        peer.ended = false;
        heard_->on_restart(node_of(id));
        linked_->on_restart(node_of(id));
    }
    peer.beacon = beacon;
    unknown_.erase(beacon.log);
    // Its particulars came after its heartbeat, and may have waited.
    if (!is_new_tick) return heard(has_news);
    return on_tick_of(now, peer, has_news);
}

Membership::Heard Membership::on_heartbeat(Instant now, const LogId& log, const Join& join) {
    const auto known = peers_.find(log.broker);
    if (known == peers_.end() || known->second.beacon.log != log) {
        (void)join(nullptr);
        const Instant forgotten = now - times().silent_home_waited_for();
        std::erase_if(unknown_, [&](const auto& each) { return each.second <= forgotten; });
        if (unknown_.size() < peers_known) unknown_.insert_or_assign(log, now);
        return Heard::nothing;
    }
    Peer& peer = known->second;
    const News before = news_of(peer.beacon);
    if (!join(&peer.beacon)) return Heard::nothing;
    return on_tick_of(now, peer, news_of(peer.beacon) != before);
}

Membership::Heard Membership::on_tick_of(Instant now, Peer& peer, bool has_news) {
    const Beacon& beacon = peer.beacon;
    const election::NodeId node = node_of(beacon.log.broker);
    const bool was_alive = peer.alive;
    const bool was_heard = heard_->is_alive(node);
    peer.heard_at = now;
    if (beacon.leaving) {
        peer.ended = true;
        heard_->on_gone(now, node);
        linked_->on_gone(now, node);
        bury_suspects(now);
        return heard(true);
    }
    heard_->on_beacon(now, node);
    if (beacon.hears_from(self_)) {
        linked_->on_beacon(now, node);
        peer.alive = linked_->is_alive(node);
        if (peer.alive != was_alive) ++changes_;
        if (peer.alive) {
            peer.ended = false;
            elector_->on_claim(now, beacon.claim);
        }
    }
    const bool is_changed = peer.alive != was_alive || heard_->is_alive(node) != was_heard;
    return heard(has_news || is_changed);
}

Membership::Heard Membership::heard(bool has_news) {
    if (has_news) ++news_;
    return has_news ? Heard::news : Heard::life;
}

Membership::News Membership::news_of(const Beacon& beacon) const {
    return {.view = beacon.view.number,
            .claim = beacon.claim,
            .leaving = beacon.leaving,
            .hears_us = beacon.hears_from(self_)};
}

bool Membership::is_news(const Beacon& before, const Beacon& beacon) {
    return beacon.log != before.log || beacon.serving != before.serving ||
           beacon.binding != before.binding || beacon.home_addresses != before.home_addresses ||
           beacon.ended != before.ended || beacon.settings != before.settings ||
           beacon.predefined != before.predefined || beacon.link != before.link;
}

void Membership::on_pulse(Instant now, const Pulse& pulse) {
    const auto known = peers_.find(pulse.log.broker);
    if (known == peers_.end()) return;
    Peer& peer = known->second;
    if (peer.beacon.log != pulse.log || pulse.tick < peer.beacon.tick || peer.beacon.leaving)
        return;
    const election::NodeId node = node_of(pulse.log.broker);
    if (!heard_->is_alive(node)) return;
    peer.heard_at = now;
    heard_->on_beacon(now, node);
    if (peer.beacon.hears_from(self_) && linked_->is_alive(node)) linked_->on_beacon(now, node);
}

void Membership::on_leader(Instant now, BrokerId leader, election::Term term) {
    // A proposal may be numbered beyond its leader's term; in raft nobody voted for that one.
    if (options_.elector == "raft") return;
    const auto peer = peers_.find(leader);
    if (peer == peers_.end() || !peer->second.alive) return;
    election::Claim& claim = peer->second.beacon.claim;
    if (claim.term >= term) return;
    claim.term = term;
    claim.leader = node_of(leader);
    elector_->on_claim(now, claim);
}

void Membership::on_left_out(Instant now, const LogId& log) {
    const Peer* peer = find(log.broker);
    if (peer == nullptr || peer->beacon.log != log) return;
    if (!was_heard_just_now(*peer, now)) heard_->on_gone(now, node_of(log.broker));
    linked_->on_gone(now, node_of(log.broker));
    bury_suspects(now);
}

bool Membership::on_link(Instant now, const LogId& process, election::Link link) {
    const auto peer = peers_.find(process.broker);
    if (peer == peers_.end()) return false;
    if (peer->second.beacon.link.process != process.incarnation) return false;
    peer->second.ended = link == election::Link::lost;
    heard_->on_link(now, node_of(process.broker), link);
    linked_->on_link(now, node_of(process.broker), link);
    bury_suspects(now);
    return true;
}

void Membership::on_ballot(Instant now, BrokerId from, const election::Ballot& ballot) {
    elector_->on_ballot(now, node_of(from), ballot);
}

void Membership::on_condition(Instant now, std::uint32_t reading) {
    if (condition_.on_reading(reading)) elector_->on_condition(now, condition_.told());
}

void Membership::on_tick(Instant now) {
    heard_->on_tick(now);
    linked_->on_tick(now);
    bury_suspects(now);
    elector_->on_detection_time(linked_->detection_time());
    elector_->on_tick(now);
}

void Membership::send_ballots(Outbox& out) {
    for (const auto& [to, ballot] : elector_->take_ballots()) {
        out.push_back({broker_of(to), ElectionMessage{ballot}});
    }
}

void Membership::bury_suspects(Instant now) {
    if (!heard_->take_suspects().empty()) ++news_;
    for (const auto node : linked_->take_suspects()) {
        Peer& peer = peers_[broker_of(node)];
        peer.alive = false;
        ++changes_;
        ++news_;
        lost_.push_back(broker_of(node));
        elector_->on_suspect(now, node);
    }
}

void Membership::describe(Beacon& beacon) const {
    beacon.claim = elector_->claim();
    for (const auto& [id, peer] : peers_) {
        if (is_heard(id)) beacon.hears.push_back(id);
    }
}

const Peer* Membership::find(BrokerId id) const {
    const auto found = peers_.find(id);
    return found == peers_.end() ? nullptr : &found->second;
}

bool Membership::is_heard(const LogId& log) const {
    const Peer* peer = find(log.broker);
    return peer != nullptr && is_heard(log.broker) && peer->beacon.log == log;
}

bool Membership::heard_unknown(Instant now) const {
    return std::ranges::any_of(unknown_, [&](const auto& each) {
        return now < each.second + times().silent_home_waited_for();
    });
}

bool Membership::is_alive(const LogId& log) const {
    const Peer* peer = find(log.broker);
    return peer != nullptr && peer->alive && peer->beacon.log == log;
}

bool Membership::is_heard_clearly(const LogId& log, Instant now) const {
    return is_alive(log) && was_heard_just_now(*find(log.broker), now);
}

bool Membership::was_heard_just_now(const Peer& peer, Instant now) const {
    return now < peer.heard_at + times().clearly_heard_for();
}

bool Membership::has_ended(const LogId& log) const {
    const Peer* peer = find(log.broker);
    return peer != nullptr && (peer->ended || peer->beacon.log != log);
}

std::string Membership::name_of(BrokerId id) const {
    const Peer* peer = find(id);
    return peer == nullptr ? std::string{} : peer->beacon.name;
}

std::vector<BrokerId> Membership::take_lost() {
    return std::exchange(lost_, {});
}

bool Membership::leads() const {
    return leadership().leader == node_of(self_);
}

}  // namespace romano::cluster
