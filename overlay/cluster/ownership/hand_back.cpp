#include "overlay/cluster/ownership/hand_back.h"

#include <algorithm>
#include <utility>

namespace romano::cluster {
// --- the holder's side

void HandBack::compare(Effects& effects, const Membership& membership, const View& view,
                       const ServiceAddresses& addresses) {
    const auto contested_before = std::exchange(contested_, {});
    const std::set<Endpoint>& serving = addresses.serving();
    std::erase_if(rivals_, [&](const auto& entry) { return !serving.contains(entry.first); });
    for (const Endpoint& address : serving) {
        std::set<BrokerId> rivals;
        bool are_members = true;
        for (const auto& [id, peer] : membership.peers()) {
            const bool is_member = view.contains(peer.beacon.log);
            if (!peer.speaks_at(address) || (!is_member && !membership.is_heard(id))) continue;
            if (addresses.is_home(address)) {
                if (peer.is_home_of(address)) continue;
                rivals.insert(id);
                are_members &= is_member;
            } else if (peer.is_home_of(address) || id > self_) {
                contested_.insert_or_assign(address, id);
            }
        }
        const auto before = contested_before.find(address);
        if (before != contested_before.end() && !contested_.contains(address) &&
            !membership.is_heard(before->second)) {
            addresses.take_anew(effects, address);
        }
        if (rivals.empty()) {
            const auto ended = rivals_.extract(address);
            if (!ended.empty() && ended.mapped().claimed_in) addresses.announce(effects, address);
            continue;
        }
        Rivalry& rivalry = rivals_[address];
        rivalry.on_rivals(effects.now, std::move(rivals));
        if (!are_members) rivalry.together_since = effects.now;
        if (effects.now > rivalry.together_since + effects.times.rival_hands_over_within() ||
            effects.now > rivalry.since + effects.times.rival_joins_within()) {
            rivalry.is_in_vain = true;
        }
        const bool is_ours =
            rivalry.is_settled() || std::ranges::any_of(rivalry.with, [&](BrokerId id) {
                return membership.find(id)->beacon.hears_from(self_);
            });
        // A view that left us out may have had a rival take it anew: what clients answer would go
        // there.
        if (is_ours && std::exchange(rivalry.claimed_in, view.number) != view.number) {
            addresses.take_anew(effects, address);
        }
    }
}

bool HandBack::is_unsettled(const Endpoint& address) const {
    const auto rival = rivals_.find(address);
    return rival != rivals_.end() && !rival->second.is_settled();
}

/// Whoever comes new was not waited for yet, and has handed nothing over.
void HandBack::Rivalry::on_rivals(Instant now, std::set<BrokerId> rivals) {
    if (!std::ranges::includes(with, rivals)) {
        since = together_since = now;
        is_in_vain = false;
    }
    with = std::move(rivals);
    std::erase_if(handed_over, [this](BrokerId id) { return !with.contains(id); });
}

/// What one of several rivals had says nothing of what the others have (I1).
bool HandBack::Rivalry::is_settled() const {
    return is_in_vain || std::ranges::includes(handed_over, with);
}

void HandBack::carry_on(Effects& effects, const Logs& logs, const Membership& membership,
                        const View& view, ServiceAddresses& addresses, Departures& departures,
                        const NotYet& not_yet) {
    std::erase_if(expected_, [&](const auto& entry) {
        const auto& [address, expected] = entry;
        const bool is_heir = not_yet.inheriting.contains(address);  // of a giver that died
        return is_in_vain(effects, expected, is_heir, membership, view);
    });
    std::erase_if(giving_, [&](const auto& entry) {
        const auto& [address, giving] = entry;
        if (!addresses.is_serving(address)) return true;
        if (!is_called_off(effects, address, giving, membership, view, departures, not_yet)) {
            return false;
        }
        if (!membership.is_alive(giving.owner)) addresses.take_anew(effects, address);
        return true;
    });
    const std::set<Endpoint> serving = addresses.serving();
    for (const Endpoint& address : serving) {
        if (addresses.is_home(address)) continue;
        const auto under_way = giving_.find(address);
        if (under_way == giving_.end()) {
            if (not_yet.half_adopted.contains(address)) continue;
            begin(effects, address, logs, membership, view);
            continue;
        }
        Giving& giving = under_way->second;
        const Peer* owner = membership.find(giving.owner.broker);
        const bool drained = effects.now >= giving.since + effects.times.answers_leave_within() &&
                             !not_yet.pending_output.contains(address);
        if (giving.stage == Stage::draining &&
            (drained ||
             effects.now >= giving.since + effects.times.answers_leave_at_most_within())) {
            giving.stage = Stage::moving;
            giving.clients = effects.broker.client_ids_via(address);
        }
        if (giving.stage == Stage::moving && !not_yet.half_adopted.contains(address) &&
            move_some(effects, address, giving, logs.peers, departures)) {
            effects.broker.seal(address, giving.owner, effects.clients);
            giving.stage = Stage::sealed;
            giving.since = effects.now;
        } else if (giving.stage == Stage::sealed && !departures.has_any_via(address) &&
                   membership.is_alive(giving.owner) && owner->speaks_at(address)) {
            giving_.erase(under_way);
            addresses.give_up(effects, address);
        }
    }
}

/// Those who died are members until a view names who inherits, and hands them over: until then
/// nobody knows whether anything comes (I5).
bool HandBack::is_in_vain(const Effects& effects, const Expected& expected, bool is_heir,
                          const Membership& membership, const View& view) {
    const auto is_alive = [&](const LogId& life) { return membership.is_alive(life); };
    const auto is_member = [&](const LogId& life) { return view.contains(life); };
    const bool awaits_view = std::ranges::any_of(
        expected.from, [&](const LogId& life) { return is_member(life) && !is_alive(life); });
    if (effects.now > expected.since + (awaits_view ? effects.times.dead_giver_removed_within()
                                                    : effects.times.giver_waited_for())) {
        return true;
    }
    // It may not be heard yet.
    const bool is_met = effects.now > expected.since + effects.times.giver_met_within();
    if (!is_met || is_heir) return false;
    return std::ranges::none_of(
        expected.from, [&](const LogId& life) { return is_alive(life) || is_member(life); });
}

/// One that gets no answer, or whose owner is gone: what did not get there is taken back
/// (departures.h), and speaks from here again. What the owner had comes first, when it is ours.
bool HandBack::is_called_off(const Effects& effects, const Endpoint& address, const Giving& giving,
                             const Membership& membership, const View& view,
                             const Departures& departures, const NotYet& not_yet) const {
    if (giving.stage != Stage::sealed) {
        // What has begun to move may be adopted there until a view ends that log (I1).
        const bool has_begun = giving.stage == Stage::moving;
        if (has_begun && departures.has_late_ones(effects, giving.owner)) return true;
        return !view.contains(giving.owner) || (!has_begun && !membership.is_alive(giving.owner));
    }
    if (effects.now > giving.since + effects.times.handover_acknowledged_within()) return true;
    return !view.contains(giving.owner) && !not_yet.inheriting.contains(address);
}

bool HandBack::is_half_done(const Departures& departures) const {
    return std::ranges::any_of(giving_, [&](const auto& entry) {
        const Giving& giving = entry.second;
        return giving.stage == Stage::moving &&
               (!giving.awaited.empty() || departures.to(giving.owner) <= sessions_per_turn_);
    });
}

bool HandBack::is_awaited() const {
    return std::ranges::any_of(giving_,
                               [](const auto& entry) { return !entry.second.awaited.empty(); });
}

void HandBack::on_awaited(const broker::SessionHeader& client) {
    const auto giving = giving_.find(client.via);
    if (giving != giving_.end()) giving->second.awaited.insert(client.client_id);
}

void HandBack::begin(Effects& effects, const Endpoint& address, const Logs& logs,
                     const Membership& membership, const View& view) {
    const auto owner = membership.server_of(address, view, [&](const Peer& peer) {
        const bool is_higher = peer.beacon.log.broker > self_;
        return peer.is_home_of(address) || (is_higher && peer.speaks_at(address));
    });
    if (!owner) return;
    const Peer& peer = *membership.find(owner->broker);
    if (!peer.beacon.hears_from(self_) || !peer.is_serving(address)) return;
    if (!peer.follows({logs.own.id(), effects.broker.last_seq()})) return;
    giving_.emplace(
        address,
        Giving{.owner = *owner, .since = effects.now, .contested = peer.speaks_at(address)});
}

/// They change no more: nothing is heard or said here for them.
bool HandBack::move_some(Effects& effects, const Endpoint& address, Giving& giving,
                         const PeerLogs& logs, Departures& departures) const {
    const auto move = [&](const broker::ClientId& client) {
        const broker::SessionHeader* own = effects.broker.header(client);
        // One that talks to another address here came from its owner meanwhile: both gave theirs.
        if (own == nullptr || own->via != address) return;
        departures.move(effects, client, giving.owner, giving.contested ? 0 : 1, logs);
    };
    std::size_t allowed = sessions_per_turn_;
    for (; allowed > 0 && !giving.awaited.empty(); --allowed) {
        move(giving.awaited.extract(giving.awaited.begin()).value());
    }
    if (departures.to(giving.owner) > sessions_per_turn_) return false;
    for (; allowed > 0 && giving.moved < giving.clients.size(); --allowed) {
        move(giving.clients[giving.moved++]);
    }
    if (giving.moved < giving.clients.size()) return false;
    giving.clients = effects.broker.client_ids_via(address);  // an heir, we, adopted more
    giving.moved = 0;
    return giving.clients.empty();
}

bool HandBack::is_deaf(const Endpoint& address) const {
    if (contested_.contains(address)) return true;
    const auto found = giving_.find(address);
    return found != giving_.end() && found->second.stage >= Stage::moving;
}

bool HandBack::is_silent(const Endpoint& address) const {
    return is_deaf(address) || (is_unsettled(address) && !has_one_giver(address));
}

/// Another rival may speak there still (I1).
bool HandBack::has_one_giver(const Endpoint& address) const {
    const auto expected = expected_.find(address);
    const auto rivalry = rivals_.find(address);
    if (expected == expected_.end() || rivalry == rivals_.end()) return false;
    const std::set<BrokerId>& rivals = rivalry->second.with;
    if (rivals.size() != 1) return false;
    return std::ranges::all_of(expected->second.from,
                               [&](const LogId& life) { return rivals.contains(life.broker); });
}

// --- the owner's side

void HandBack::reclaim(Effects& effects, const Membership& membership, const View& view,
                       ServiceAddresses& addresses) {
    for (const Endpoint& address : addresses.home()) {
        if (addresses.is_serving(address) || addresses.is_taking(address)) continue;
        std::set<LogId> from;
        for (const LogId& member : view.members) {
            if (!membership.is_alive(member)) continue;
            const Peer& peer = *membership.find(member.broker);
            if (!peer.beacon.hears_from(self_)) continue;
            if (peer.is_serving(address) && !peer.is_home_of(address)) from.insert(member);
        }
        const auto tried = tried_.find(address);
        const bool is_too_soon = tried != tried_.end() &&
                                 effects.now < tried->second + effects.times.binding_tried_every();
        if (from.empty() || is_too_soon) continue;
        reclaiming_.insert_or_assign(address, std::move(from));
        addresses.take(effects, address);
    }
}

void HandBack::on_address(Instant now, const Endpoint& address, bool served) {
    auto reclaiming = reclaiming_.extract(address);
    if (reclaiming.empty()) return;
    if (served) {
        expect(now, address, std::move(reclaiming.mapped()));
        tried_.erase(address);
    } else {
        tried_.insert_or_assign(address, now);
    }
}

std::vector<Endpoint> HandBack::binding() const {
    std::vector<Endpoint> addresses;
    for (const auto& [address, expected] : expected_) addresses.push_back(address);
    return addresses;
}

void HandBack::expect(Instant now, const Endpoint& address, std::set<LogId> from) {
    Expected& expected = expected_[address];
    expected.from.merge(std::move(from));
    expected.since = now;
}

void HandBack::on_handed_over(BrokerId from, const Endpoint& address) {
    // The former holder's next beacons may still name the address; it is silent there by now.
    const auto rivalry = rivals_.find(address);
    const bool is_rival = rivalry != rivals_.end() && rivalry->second.with.contains(from);
    const bool is_news = !is_rival || rivalry->second.handed_over.insert(from).second;
    const auto expected = expected_.find(address);
    if (expected != expected_.end()) {
        const auto is_from = [&](const LogId& life) { return life.broker == from; };
        const bool was_meant = std::erase_if(expected->second.from, is_from) != 0;
        const bool was_somebody_elses = !was_meant && is_news;  // whoever was meant passed it on
        if (was_somebody_elses || expected->second.from.empty()) expected_.erase(expected);
    }
}

}  // namespace romano::cluster
