#include "overlay/cluster/ownership/homes.h"

#include <algorithm>

namespace romano::cluster {

void Homes::on_event(BrokerId peer, const broker::LogEvent& event) {
    if (const auto* session = std::get_if<broker::SessionPut>(&event)) {
        put(peer, session->image.header);
    } else if (const auto* changed = std::get_if<broker::SessionChanged>(&event)) {
        put(peer, changed->header);
    } else if (const broker::ClientId* left = broker::leaver(event)) {
        forget(peer, *left);
    } else if (const auto* published = std::get_if<broker::Published>(&event)) {
        if (!published->will_of.empty()) lose(peer, published->will_of);
    }
}

void Homes::reset(BrokerId peer, const broker::Mirror& sessions) {
    forget(peer);
    sessions.visit([&](const broker::SessionImage& image) { put(peer, image.header); });
}

void Homes::forget(BrokerId peer) {
    for (auto& [client, claims] : by_client_) take_back(peer, client, claims);
    std::erase_if(by_client_, [](const auto& entry) { return entry.second.empty(); });
}

std::optional<Home> Homes::of(const broker::ClientId& client) const {
    const auto found = by_client_.find(client);
    if (found == by_client_.end()) return std::nullopt;
    return Home{client, found->second.back().broker};
}

std::optional<Home> Homes::at(const broker::Origin& place) const {
    const auto found = by_address_.find(place.from);
    if (found == by_address_.end()) return std::nullopt;
    const auto heard = std::ranges::find(found->second, place.via, &Heard::via);
    return heard == found->second.end() ? std::nullopt : of(heard->client_id);
}

std::optional<Home> Homes::only_one_at(const broker::ClientAddress& address) const {
    const auto found = by_address_.find(address);
    if (found == by_address_.end()) return std::nullopt;
    const Heard* only = nullptr;
    for (const Heard& heard : found->second) {
        if (!heard.is_connected) continue;
        if (only != nullptr && only->client_id != heard.client_id) return std::nullopt;
        only = &heard;
    }
    return only == nullptr ? std::nullopt : of(only->client_id);
}

bool Homes::share_address_with(const broker::SessionHeader& client) const {
    const auto found = by_address_.find(client.address);
    if (found == by_address_.end()) return false;
    return std::ranges::any_of(found->second, [&client](const Heard& heard) {
        const bool is_displaced = heard.via == client.via && heard.at < client.last_heard;
        return heard.is_connected && heard.client_id != client.client_id && !is_displaced;
    });
}

void Homes::put(BrokerId peer, const broker::SessionHeader& header) {
    Claims& claims = by_client_[header.client_id];
    take_back(peer, header.client_id, claims);
    const broker::Origin place{header.via, header.address};
    claims.push_back({peer, place});
    if (!broker::has_place(place.from)) return;
    std::vector<Heard>& all = by_address_[place.from];
    Heard heard{place.via, header.client_id, header.last_heard, broker::is_connected(header)};
    const auto same = std::ranges::find(all, place.via, &Heard::via);
    if (same == all.end()) {
        all.push_back(std::move(heard));
    } else if (same->client_id == heard.client_id || same->at <= heard.at) {
        *same = std::move(heard);
    }
}

void Homes::forget(BrokerId peer, const broker::ClientId& client) {
    const auto found = by_client_.find(client);
    if (found == by_client_.end()) return;
    take_back(peer, client, found->second);
    if (found->second.empty()) by_client_.erase(found);
}

void Homes::take_back(BrokerId peer, const broker::ClientId& client, Claims& claims) {
    const auto claim = std::ranges::find(claims, peer, &Claim::broker);
    if (claim == claims.end()) return;
    const broker::Origin place = claim->place;
    claims.erase(claim);
    if (std::ranges::count(claims, place, &Claim::place) == 0) leave(client, place);
}

void Homes::lose(BrokerId peer, const broker::ClientId& client) {
    const auto claims = by_client_.find(client);
    if (claims == by_client_.end()) return;
    const auto claim = std::ranges::find(claims->second, peer, &Claim::broker);
    if (claim == claims->second.end()) return;
    const auto found = by_address_.find(claim->place.from);
    if (found == by_address_.end()) return;
    for (Heard& heard : found->second) {
        if (heard.via == claim->place.via && heard.client_id == client) heard.is_connected = false;
    }
}

void Homes::leave(const broker::ClientId& client, const broker::Origin& place) {
    const auto found = by_address_.find(place.from);
    if (found == by_address_.end()) return;
    std::erase_if(found->second, [&](const Heard& heard) {
        return heard.via == place.via && heard.client_id == client;
    });
    if (found->second.empty()) by_address_.erase(found);
}

}  // namespace romano::cluster
