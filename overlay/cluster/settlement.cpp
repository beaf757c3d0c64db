#include "overlay/cluster/settlement.h"

#include <algorithm>

#include "overlay/cluster/session_handoff.h"

namespace romano::cluster {

void Settlement::on_peer_session(const Effects& effects, BrokerId peer,
                                 const broker::ClientId& client) {
    if (effects.broker.image(client)) conflicts_.emplace(client, peer);
}

void Settlement::compare(const Effects& effects, const PeerLogs& logs, const View& view) {
    const auto own = effects.broker.images();
    for (const LogId& member : view.members) {
        const auto log = logs.find(member);
        if (log == logs.end()) continue;
        for (const auto& image : own) {
            const broker::ClientId& client = image.header.client_id;
            if (log->second.mirror().contains(client)) conflicts_.emplace(client, member.broker);
        }
    }
}

void Settlement::carry_on(Effects& effects, const PeerLogs& logs) {
    if (effects.now < next_claims_) return;
    next_claims_ = effects.now + patience_;
    std::erase_if(giving_way_, [&](const auto& entry) {
        return effects.now > entry.second.second + 10 * patience_;  // not acknowledged
    });
    std::erase_if(conflicts_, [&](const auto& conflict) {
        const auto& [client, peer] = conflict;
        const bool held_there = std::ranges::any_of(logs, [&](const auto& entry) {
            return entry.first.broker == peer && !entry.second.is_frozen() &&
                   entry.second.mirror().contains(client);
        });
        const auto image = effects.broker.image(client);
        if (!held_there || !image) return true;
        if (!giving_way_.contains(client)) {
            effects.peers.push_back({peer, SessionClaim{image->header}});
        }
        return false;
    });
}

void Settlement::on_claim(Effects& effects, BrokerId from, const SessionClaim& claim) {
    const broker::ClientId& client = claim.header.client_id;
    auto own = effects.broker.image(client);
    if (!own || giving_way_.contains(client)) return;
    const bool stays = broker::outranks(own->header, claim.header) ||
                       (!broker::outranks(claim.header, own->header) && self_ > from);
    if (stays) {
        conflicts_.emplace(client, from);  // and say so
        return;
    }
    give_way(effects, from, *std::move(own));
}

void Settlement::on_request(Effects& effects, BrokerId from, const SessionRequest& request) {
    auto own = effects.broker.image(request.client_id);
    if (!own || giving_way_.contains(request.client_id)) return;
    ++own->header.epoch;  // both agreed: as good as being heard there
    give_way(effects, from, *std::move(own));
}

void Settlement::give_way(Effects& effects, BrokerId to, broker::SessionImage image) {
    giving_way_.emplace(image.header.client_id, std::pair{to, effects.now});
    std::vector<broker::SessionImage> images;
    images.push_back(std::move(image));
    send_handoff(to, Endpoint{}, std::move(images), effects.peers);
}

void Settlement::on_ack(Effects& effects, BrokerId from, const HandoffAck& ack) {
    const auto giving = giving_way_.find(ack.client_id);
    if (giving == giving_way_.end() || giving->second.first != from) return;
    giving_way_.erase(giving);
    (void)effects.broker.release(ack.client_id, effects.clients);
}

void Settlement::restart() {
    conflicts_.clear();
    giving_way_.clear();
}

}  // namespace romano::cluster
