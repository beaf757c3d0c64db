#include "overlay/cluster/ownership/hand_back.h"

#include <algorithm>
#include <utility>

#include "overlay/cluster/ownership/session_handoff.h"

namespace romano::cluster {
// --- the holder's side

std::optional<LogId> HandBack::owner_of(const Endpoint& address, const Membership& membership,
                                        const View& view) const {
    std::optional<LogId> highest;
    for (const LogId& member : view.members) {
        if (member.broker == self_ || !membership.is_alive(member)) continue;
        const Peer& peer = *membership.find(member.broker);
        if (peer.is_home_of(address)) return member;
        if (peer.is_serving(address) && member.broker > (highest ? highest->broker : self_)) {
            highest = member;
        }
    }
    return highest;
}

void HandBack::compare(Effects& effects, const Membership& membership, const View& view,
                       const ServiceAddresses& addresses) {
    const auto contested_before = std::exchange(contested_, {});
    for (const Endpoint& address : addresses.serving()) {
        std::set<BrokerId> rivals;
        bool are_members = true;
        for (const auto& [id, peer] : membership.peers()) {
            const bool is_member = view.contains(peer.beacon.log);
            if (!peer.is_serving(address) || (!is_member && !membership.is_heard(id))) continue;
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
            if (!ended.empty() && ended.mapped().is_claimed) addresses.announce(effects, address);
            continue;
        }
        Rivalry& rivalry = rivals_
                               .try_emplace(address, Rivalry{.with = {},
                                                             .since = effects.now,
                                                             .together_since = effects.now})
                               .first->second;
        rivalry.with = std::move(rivals);
        if (!are_members) rivalry.together_since = effects.now;
        if (effects.now > rivalry.together_since + effects.times.rival_hands_over_within() ||
            effects.now > rivalry.since + effects.times.rival_joins_within()) {
            rivalry.is_settled = true;
        }
        const bool is_ours =
            rivalry.is_settled || std::ranges::any_of(rivalry.with, [&](BrokerId id) {
                return membership.find(id)->hears(self_);
            });
        if (is_ours && !std::exchange(rivalry.is_claimed, true)) {
            addresses.take_anew(effects, address);
        }
    }
}

bool HandBack::is_unsettled(const Endpoint& address) const {
    const auto rival = rivals_.find(address);
    return rival != rivals_.end() && !rival->second.is_settled;
}

void HandBack::carry_on(Effects& effects, const Membership& membership, const View& view,
                        ServiceAddresses& addresses, const NotYet& not_yet) {
    std::erase_if(expected_, [&](const auto& entry) {
        const Expected& expected = entry.second;
        if (effects.now > expected.since + effects.times.giver_waited_for()) return true;
        // We may not have met yet, though its offer is here.
        if (effects.now <= expected.since + effects.times.giver_met_within()) return false;
        return std::ranges::all_of(expected.from, [&](BrokerId id) {
            const Peer* from = membership.find(id);
            // One that died is a member until somebody else inherits them, and hands them over.
            return from == nullptr || (!from->alive && !view.contains(from->beacon.log));
        });
    });
    std::erase_if(giving_, [&](const auto& entry) {
        const auto& [address, giving] = entry;
        if (!addresses.is_serving(address)) return true;
        if (!is_called_off(effects, address, giving, membership, view, not_yet)) return false;
        if (!membership.is_alive(giving.owner)) addresses.take_anew(effects, address);
        return true;
    });
    const std::set<Endpoint> serving = addresses.serving();
    for (const Endpoint& address : serving) {
        if (addresses.is_home(address)) continue;
        const auto under_way = giving_.find(address);
        if (under_way == giving_.end()) {
            if (not_yet.half_adopted.contains(address)) continue;
            begin(effects, address, membership, view);
            continue;
        }
        Giving& giving = under_way->second;
        const bool drained = effects.now >= giving.since + effects.times.answers_leave_within() &&
                             !not_yet.pending_output.contains(address);
        if (giving.stage == Stage::draining &&
            (drained ||
             effects.now >= giving.since + effects.times.answers_leave_at_most_within())) {
            hand_over(effects, address, giving);
        } else if (giving.stage == Stage::handed) {
            send_some(effects, address, giving);
        } else if (giving.stage == Stage::acknowledged && forget_some(effects, address, giving)) {
            giving_.erase(under_way);
            addresses.give_up(effects, address);
        }
    }
}

void HandBack::on_view(const ViewAnnouncement& announcement) {
    for (auto& [address, giving] : giving_) {
        for (const Assignment& assignment : announcement.assignments) {
            if (assignment.end.log != giving.owner || assignment.address != address) continue;
            giving.heir = assignment.heir;
        }
    }
}

/// Until it hands over what it has, or, when the address shall stay with it, until it serves that:
/// then it gets ours (compare()).
bool HandBack::is_with_heir(const Endpoint& address, const Giving& giving,
                            const Membership& membership, const View& view) const {
    if (!giving.heir || *giving.heir == self_) return false;
    const Peer* heir = membership.find(*giving.heir);
    if (heir == nullptr || !view.contains(heir->beacon.log)) return false;
    return *giving.heir < self_ || !heir->is_serving(address);
}

/// One that gets no answer, or whose owner began anew meanwhile: the sessions speak from here
/// again. If the owner may have spoken for them, what it said comes first, from its log, or from
/// its heir.
bool HandBack::is_called_off(const Effects& effects, const Endpoint& address, const Giving& giving,
                             const Membership& membership, const View& view,
                             const NotYet& not_yet) const {
    if (giving.stage == Stage::acknowledged) return false;
    const Duration limit = giving.stage == Stage::offered
                               ? effects.times.offer_stands_for()
                               : effects.times.handover_acknowledged_within();
    if (effects.now > giving.since + limit) return true;
    if (!giving.all_sent) return !membership.is_alive(giving.owner);
    return !view.contains(giving.owner) && !not_yet.inheriting.contains(address) &&
           !is_with_heir(address, giving, membership, view);
}

void HandBack::forget_for_the_dead(Effects& effects, const View& view,
                                   ServiceAddresses& addresses) {
    for (auto at = giving_.begin(); at != giving_.end();) {
        auto& [address, giving] = *at;
        if (giving.stage != Stage::acknowledged || view.contains(giving.owner)) {
            ++at;
            continue;
        }
        while (!forget_some(effects, address, giving)) {
        }
        addresses.give_up(effects, address);
        at = giving_.erase(at);
    }
}

bool HandBack::is_half_done() const {
    return std::ranges::any_of(giving_, [](const auto& entry) {
        const Giving& giving = entry.second;
        return giving.stage == Stage::acknowledged ||
               (giving.stage == Stage::handed && !giving.all_sent);
    });
}

void HandBack::begin(Effects& effects, const Endpoint& address, const Membership& membership,
                     const View& view) {
    const auto owner = owner_of(address, membership, view);
    if (!owner) return;
    const Peer& peer = *membership.find(owner->broker);
    if (!peer.hears(self_)) return;  // what it is sent would be lost
    const bool contested = peer.is_serving(address);
    giving_.emplace(address, Giving{.owner = *owner,
                                    .stage = contested ? Stage::draining : Stage::offered,
                                    .since = effects.now,
                                    .contested = contested});
    if (!contested) effects.peers.push_back({owner->broker, AddressOffer{address}});
}

void HandBack::on_bound(Instant now, BrokerId from, const AddressBound& bound) {
    const auto found = giving_.find(bound.address);
    if (found == giving_.end() || found->second.owner.broker != from) return;
    if (found->second.stage != Stage::offered) return;
    found->second.stage = Stage::draining;
    found->second.since = now;
}

void HandBack::hand_over(Effects& effects, const Endpoint& address, Giving& giving) {
    giving.stage = Stage::handed;
    giving.clients = effects.broker.client_ids_via(address);
    send_some(effects, address, giving);
}

/// They change no more: nothing is heard or said here for them.
void HandBack::send_some(Effects& effects, const Endpoint& address, Giving& giving) const {
    if (giving.all_sent) return;
    const std::size_t end = std::min(giving.sent + sessions_per_turn_, giving.clients.size());
    std::vector<broker::SessionImage> images;
    for (; giving.sent < end; ++giving.sent) {
        auto image = effects.broker.image(giving.clients[giving.sent]);
        if (!image || image->header.via != address) continue;
        giving.speaking_from.insert(image->header.address.endpoint);
        if (!giving.contested) ++image->header.epoch;
        images.push_back(*std::move(image));
    }
    giving.all_sent = giving.sent == giving.clients.size();
    giving.since = effects.now;
    giving.next_part = send_handoff_piece(giving.owner, address, giving.next_part,
                                          std::move(images), giving.all_sent, effects.peers);
}

void HandBack::on_ack(Effects& effects, BrokerId from, const HandoffAck& ack,
                      ServiceAddresses& addresses) {
    const auto found = giving_.find(ack.address);
    if (found == giving_.end() || found->second.owner.broker != from ||
        found->second.stage != Stage::handed || !found->second.all_sent) {
        return;
    }
    found->second.stage = Stage::acknowledged;
    if (!forget_some(effects, ack.address, found->second)) return;
    giving_.erase(found);
    addresses.give_up(effects, ack.address);
}

bool HandBack::forget_some(Effects& effects, const Endpoint& address, Giving& giving) const {
    const std::size_t end = std::min(giving.forgotten + sessions_per_turn_, giving.clients.size());
    for (; giving.forgotten < end; ++giving.forgotten) {
        const broker::ClientId& client = giving.clients[giving.forgotten];
        // One that talks to another address here came from its owner meanwhile: both gave theirs.
        const broker::SessionHeader* own = effects.broker.header(client);
        if (own == nullptr || own->via != address) continue;
        (void)effects.broker.release(client, effects.clients);
    }
    return giving.forgotten == giving.clients.size();
}

bool HandBack::is_deaf(const Endpoint& address) const {
    if (contested_.contains(address)) return true;
    const auto found = giving_.find(address);
    return found != giving_.end() && found->second.stage >= Stage::handed;
}

bool HandBack::is_leaving(const Endpoint& client) const {
    return std::ranges::any_of(
        giving_, [&](const auto& entry) { return entry.second.speaking_from.contains(client); });
}

bool HandBack::is_silent(const Endpoint& address) const {
    return is_deaf(address) || (is_unsettled(address) && !expected_.contains(address));
}

// --- the owner's side

void HandBack::on_offer(Effects& effects, BrokerId from, const AddressOffer& offer,
                        ServiceAddresses& addresses) {
    if (!addresses.is_home(offer.address) || addresses.is_serving(offer.address)) return;
    taking_.insert_or_assign(offer.address, from);
    addresses.take(effects, offer.address);
}

void HandBack::on_address(Effects& effects, const Endpoint& address, bool served) {
    const auto taking = taking_.extract(address);
    if (taking.empty() || !served) return;
    const BrokerId from = taking.mapped();
    effects.peers.push_back({from, AddressBound{address}});
    expect(effects.now, address, {from});
}

void HandBack::expect(Instant now, const Endpoint& address, std::set<BrokerId> from) {
    expected_.insert_or_assign(address, Expected{std::move(from), now});
}

void HandBack::on_handed_over(BrokerId from, const Endpoint& address) {
    const auto expected = expected_.find(address);
    if (expected != expected_.end()) {
        const bool was_meant = expected->second.from.erase(from) != 0;
        if (!was_meant || expected->second.from.empty()) expected_.erase(expected);
    }
    const auto giving = giving_.find(address);
    if (giving != giving_.end() && giving->second.heir == from) giving->second.heir.reset();
    // The former holder's next beacons may still name the address; it is silent there by now.
    // Another heir's word says nothing of what the rival has.
    const auto rivalry = rivals_.find(address);
    if (rivalry != rivals_.end() && rivalry->second.with.contains(from)) {
        rivalry->second.is_settled = true;
    }
}

}  // namespace romano::cluster
