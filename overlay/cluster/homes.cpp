#include "overlay/cluster/homes.h"

#include <algorithm>

namespace romano::cluster {

void Homes::on_event(BrokerId peer, const broker::LogEvent& event) {
    if (const auto* session = std::get_if<broker::SessionPut>(&event)) {
        put(peer, session->image.header);
    } else if (const auto* changed = std::get_if<broker::SessionChanged>(&event)) {
        put(peer, changed->header);
    } else if (const auto* erased = std::get_if<broker::SessionErased>(&event)) {
        forget(peer, erased->client_id);
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

std::optional<Home> Homes::at(const broker::ClientAddress& address) const {
    const auto found = by_address_.find(address);
    return found == by_address_.end() ? std::nullopt : of(found->second);
}

void Homes::put(BrokerId peer, const broker::SessionHeader& header) {
    Claims& claims = by_client_[header.client_id];
    take_back(peer, header.client_id, claims);
    claims.push_back({peer, header.address});
    by_address_.insert_or_assign(header.address, header.client_id);
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
    const broker::ClientAddress address = claim->address;
    claims.erase(claim);
    if (std::ranges::count(claims, address, &Claim::address) > 0) return;
    const auto known = by_address_.find(address);
    if (known != by_address_.end() && known->second == client) by_address_.erase(known);
}

}  // namespace romano::cluster
