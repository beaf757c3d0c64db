#include "overlay/cluster/ownership/settlement.h"

#include <algorithm>
#include <span>

#include "overlay/cluster/ownership/session_handoff.h"

namespace romano::cluster {

void Settlement::on_peer_session(const Effects& effects, BrokerId peer,
                                 const broker::ClientId& client) {
    if (effects.broker.header(client) != nullptr) conflicts_.emplace(client, peer);
}

void Settlement::compare(const broker::BrokerCore& broker, const View& view) {
    to_compare_ = broker.client_ids();
    compared_with_ = view.members;
}

void Settlement::compare_some(const PeerLogs& logs) {
    const std::size_t count = std::min(to_compare_.size(), compared_per_turn);
    const auto piece = std::span{to_compare_}.last(count);
    for (const LogId& member : compared_with_) {
        const auto log = logs.find(member);
        if (log == logs.end()) continue;
        for (const broker::ClientId& client : piece) {
            if (log->second.mirror().contains(client)) conflicts_.emplace(client, member.broker);
        }
    }
    to_compare_.resize(to_compare_.size() - count);
}

void Settlement::carry_on(Effects& effects, const Logs& logs, const Membership& membership,
                          const HandBack& moving) {
    std::erase_if(leaving_, [&](const auto& entry) {
        const Leaving& leaving = entry.second;
        const Peer* peer = membership.find(leaving.to.broker);
        const bool hopeless = peer == nullptr || !membership.is_alive(leaving.to);
        if (!hopeless && effects.now < leaving.since + effects.times.handover_acknowledged_within())
            return false;
        adopt(effects, logs, leaving.image);  // it did not get there
        return true;
    });
    if (effects.now < next_claims_) return;
    next_claims_ = effects.now + effects.times.claims_repeated_every();
    std::erase_if(conflicts_, [&](const auto& conflict) {
        const broker::ClientId& client = conflict.first;
        const BrokerId peer = conflict.second;
        const bool held_there = std::ranges::any_of(logs.peers, [&](const auto& entry) {
            return entry.first.broker == peer && !entry.second.is_frozen() &&
                   entry.second.mirror().contains(client);
        });
        const auto image = effects.broker.image(client);
        if (!held_there || !image) return true;
        if (moving.is_silent(image->header.via)) return false;
        effects.peers.push_back({peer, SessionClaim{image->header}});
        return false;
    });
}

void Settlement::on_claim(Effects& effects, const LogId& from, const SessionClaim& claim,
                          const HandBack& moving, bool is_foreign) {
    const broker::ClientId& client = claim.header.client_id;
    auto own = effects.broker.image(client);
    if (!own || moving.is_silent(own->header.via)) return;
    const auto precedes = [is_foreign](const auto& a, const auto& b) {
        return is_foreign ? a.last_heard > b.last_heard : broker::outranks(a, b);
    };
    const bool stays = precedes(own->header, claim.header) ||
                       (!precedes(claim.header, own->header) && self_ > from.broker);
    if (stays) {
        conflicts_.emplace(client, from.broker);  // and say so
        return;
    }
    give_way(effects, from, *std::move(own));
}

void Settlement::on_request(Effects& effects, const LogId& from, const SessionRequest& request,
                            const HandBack& moving) {
    auto own = effects.broker.image(request.client_id);
    if (!own || moving.is_silent(own->header.via)) return;
    ++own->header.epoch;  // both agreed: as good as being heard there
    give_way(effects, from, *std::move(own));
}

void Settlement::give_way(Effects& effects, const LogId& to, broker::SessionImage image) {
    const broker::ClientId client = image.header.client_id;
    std::vector<broker::SessionImage> images;
    images.push_back(image);
    send_handoff(to, Endpoint{}, std::move(images), effects.peers);
    (void)effects.broker.release(client, effects.clients);
    leaving_.insert_or_assign(client, Leaving{to, effects.now, std::move(image)});
}

void Settlement::on_ack(BrokerId from, const HandoffAck& ack) {
    const auto leaving = leaving_.find(ack.client_id);
    if (leaving != leaving_.end() && leaving->second.to.broker == from) leaving_.erase(leaving);
}

}  // namespace romano::cluster
