#include "overlay/cluster/homes.h"

namespace romano::cluster {

void Homes::on_event(BrokerId peer, const broker::LogEvent& event) {
    if (const auto* session = std::get_if<broker::SessionPut>(&event)) {
        put(peer, session->image.header);
    } else if (const auto* changed = std::get_if<broker::SessionChanged>(&event)) {
        put(peer, changed->header);
    } else if (const auto* erased = std::get_if<broker::SessionErased>(&event)) {
        erase(peer, erased->client_id);
    }
}

void Homes::reset(BrokerId peer, const broker::Mirror& sessions) {
    forget(peer);
    sessions.visit([&](const broker::SessionImage& image) { put(peer, image.header); });
}

void Homes::forget(BrokerId peer) {
    std::erase_if(by_client_, [&](const auto& entry) {
        if (entry.second.broker != peer) return false;
        by_address_.erase(entry.second.address);
        return true;
    });
}

std::optional<Home> Homes::of(const broker::ClientId& client) const {
    const auto found = by_client_.find(client);
    if (found == by_client_.end()) return std::nullopt;
    return Home{client, found->second.broker};
}

std::optional<Home> Homes::at(const broker::ClientAddress& address) const {
    const auto found = by_address_.find(address);
    return found == by_address_.end() ? std::nullopt : of(found->second);
}

void Homes::put(BrokerId peer, const broker::SessionHeader& header) {
    Entry& entry = by_client_[header.client_id];
    const auto former = by_address_.find(entry.address);
    if (former != by_address_.end() && former->second == header.client_id) {
        by_address_.erase(former);
    }
    entry = {peer, header.address};
    by_address_.insert_or_assign(header.address, header.client_id);
}

void Homes::erase(BrokerId peer, const broker::ClientId& client) {
    const auto found = by_client_.find(client);
    if (found == by_client_.end() || found->second.broker != peer) return;
    const auto address = by_address_.find(found->second.address);
    if (address != by_address_.end() && address->second == client) by_address_.erase(address);
    by_client_.erase(found);
}

}  // namespace romano::cluster
