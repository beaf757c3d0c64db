#include "overlay/cluster/ownership/settlement.h"

#include <algorithm>
#include <span>

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

void Settlement::carry_on(Effects& effects, const PeerLogs& logs, const HandBack& moving) {
    if (effects.now < next_claims_) return;
    next_claims_ = effects.now + effects.times.claims_repeated_every();
    std::erase_if(conflicts_, [&](const auto& conflict) {
        const broker::ClientId& client = conflict.first;
        const BrokerId peer = conflict.second;
        const bool held_there = std::ranges::any_of(logs, [&](const auto& entry) {
            return entry.first.broker == peer && !entry.second.is_frozen() &&
                   entry.second.mirror().contains(client);
        });
        const broker::SessionHeader* own = effects.broker.header(client);
        if (!held_there || own == nullptr) return true;
        if (moving.is_silent(own->via)) return false;
        effects.peers.push_back({peer, SessionClaim{*own}});
        return false;
    });
}

void Settlement::on_claim(Effects& effects, const LogId& from, const SessionClaim& claim,
                          const HandBack& moving, Departures& departures, const PeerLogs& logs) {
    const broker::ClientId& client = claim.header.client_id;
    const broker::SessionHeader* own = effects.broker.header(client);
    if (own == nullptr || moving.is_silent(own->via)) return;
    const auto log = logs.find(from);
    const bool is_foreign = log != logs.end() && log->second.is_foreign();
    const auto precedes = [is_foreign](const auto& a, const auto& b) {
        return is_foreign ? a.last_heard > b.last_heard : broker::outranks(a, b);
    };
    const bool stays =
        precedes(*own, claim.header) || (!precedes(claim.header, *own) && self_ > from.broker);
    if (stays) {
        conflicts_.emplace(client, from.broker);  // and say so
        return;
    }
    departures.move(effects, client, from, 0, logs);
}

}  // namespace romano::cluster
