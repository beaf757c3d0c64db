#include "overlay/cluster/ownership/homes.h"

#include <algorithm>
#include <iterator>
#include <utility>

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
    erase_claims(peer, [this](const Claim& claim) { return place_in_time(claim) != 0; });
    sessions.visit([&](const broker::SessionImage& image) { put(peer, image.header); });
}

void Homes::on_end(BrokerId peer) {
    ended_.insert_or_assign(peer, claims_heard_);
}

void Homes::forget(BrokerId peer) {
    ended_.erase(peer);
    erase_claims(peer, [](const Claim&) { return true; });
}

void Homes::forget_ended(BrokerId peer) {
    erase_claims(peer, [this](const Claim& claim) { return place_in_time(claim) == 0; });
}

void Homes::forget_ended(BrokerId peer, const broker::ClientId& client) {
    const auto found = find(peer, client);
    if (found != by_client_.end() && place_in_time(found->second) == 0) erase(found);
}

template <typename IsOne>
void Homes::erase_claims(BrokerId peer, IsOne&& is_one) {
    for (auto at = by_client_.begin(); at != by_client_.end();) {
        const Claim& claim = at->second;
        at = claim.broker == peer && is_one(claim) ? erase(at) : std::next(at);
    }
}

std::optional<BrokerId> Homes::of(const broker::ClientId& client) const {
    const auto [first, end] = by_client_.equal_range(client);
    if (first == end) return std::nullopt;
    const auto newest = std::max_element(first, end, [this](const Entry& a, const Entry& b) {
        return place_in_time(a.second) < place_in_time(b.second);
    });
    return newest->second.broker;
}

std::uint64_t Homes::place_in_time(const Claim& claim) const {
    const auto ended = ended_.find(claim.broker);
    return ended != ended_.end() && claim.number <= ended->second ? 0 : claim.number;
}

std::optional<broker::ClientId> Homes::at(const broker::Origin& place) const {
    const Entry* there = nullptr;
    visit(place.from, [&](const Entry& entry) {
        if (entry.second.is_there && entry.second.place.via == place.via) there = &entry;
    });
    return there == nullptr ? std::nullopt : std::optional{there->first};
}

std::optional<broker::ClientId> Homes::only_one_at(const broker::ClientAddress& address) const {
    const Entry* only = nullptr;
    bool are_several = false;
    visit(address, [&](const Entry& entry) {
        if (!entry.second.is_there || !entry.second.is_connected) return;
        are_several = are_several || (only != nullptr && only->first != entry.first);
        only = &entry;
    });
    return only == nullptr || are_several ? std::nullopt : std::optional{only->first};
}

bool Homes::share_address_with(const broker::SessionHeader& client) const {
    bool do_share = false;
    visit(client.address, [&](const Entry& entry) {
        const auto& [other, claim] = entry;
        const bool is_displaced =
            claim.place.via == client.via && claim.heard_at < client.last_heard;
        do_share = do_share || (claim.is_there && claim.is_connected && other != client.client_id &&
                                !is_displaced);
    });
    return do_share;
}

void Homes::put(BrokerId peer, const broker::SessionHeader& header) {
    forget(peer, header.client_id);
    Claim claim{.broker = peer,
                .place = {header.via, header.address},
                .heard_at = header.last_heard,
                .number = ++claims_heard_,
                .is_connected = broker::is_connected(header)};
    Entry& entry = *by_client_.emplace(header.client_id, std::move(claim));
    const broker::ClientAddress& address = entry.second.place.from;
    if (!broker::has_place(address)) return;
    by_address_.insert(broker::ClientAddressHash{}(address), &entry);
    settle_place_of(entry);
}

void Homes::settle_place_of(const Entry& newest) {
    const auto& [client, claim] = newest;
    const auto visit_there = [&](auto&& look) {
        visit(claim.place.from, [&](Entry& entry) {
            if (entry.second.place.via == claim.place.via) look(entry.first, entry.second);
        });
    };
    bool is_there = true;
    visit_there([&](const broker::ClientId& other, const Claim& at) {
        if (other != client && at.is_there && at.heard_at > claim.heard_at) is_there = false;
    });
    visit_there([&](const broker::ClientId& other, Claim& at) {
        if (other == client) {
            at.heard_at = claim.heard_at;
            at.is_connected = claim.is_connected;
            at.is_there = is_there;
        } else if (is_there) {
            at.is_there = false;
        }
    });
}

void Homes::forget(BrokerId peer, const broker::ClientId& client) {
    const auto found = find(peer, client);
    if (found != by_client_.end()) erase(found);
}

void Homes::lose(BrokerId peer, const broker::ClientId& client) {
    const auto lost = find(peer, client);
    if (lost == by_client_.end()) return;
    const auto [first, end] = by_client_.equal_range(client);
    for (auto at = first; at != end; ++at) {
        if (at->second.place == lost->second.place) at->second.is_connected = false;
    }
}

Homes::Claims::iterator Homes::find(BrokerId peer, const broker::ClientId& client) {
    const auto [first, end] = by_client_.equal_range(client);
    const auto found = std::find_if(
        first, end, [peer](const Entry& entry) { return entry.second.broker == peer; });
    return found == end ? by_client_.end() : found;
}

Homes::Claims::iterator Homes::erase(Claims::iterator entry) {
    const broker::ClientAddress& address = entry->second.place.from;
    if (broker::has_place(address)) {
        by_address_.erase(broker::ClientAddressHash{}(address), &*entry);
    }
    return by_client_.erase(entry);
}

template <typename Look>
void Homes::visit(const broker::ClientAddress& address, Look&& look) const {
    by_address_.visit(broker::ClientAddressHash{}(address), [&](Entry& entry) {
        if (entry.second.place.from == address) look(entry);
    });
}

}  // namespace romano::cluster
