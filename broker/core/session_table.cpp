#include "broker/core/session_table.h"

#include <algorithm>
#include <cassert>

namespace romano::broker {

Session& SessionTable::create(std::string_view client_id) {
    assert(!by_id_.contains(client_id));
    SessionNumber number = static_cast<SessionNumber>(slots_.size());
    if (free_.empty()) {
        slots_.emplace_back();
    } else {
        number = free_.back();
        free_.pop_back();
    }
    slots_[number] = std::make_unique<Session>(number);
    Session& session = *slots_[number];
    session.header.client_id = client_id;
    by_id_.emplace(session.header.client_id, &session);
    return session;
}

void SessionTable::erase(Session& session) {
    unmap(session);
    come_back(session);
    find_again(session);
    by_id_.erase(session.header.client_id);
    free_.push_back(session.number);
    slots_[session.number].reset();
}

Session* SessionTable::find(std::string_view client_id) const {
    const auto found = by_id_.find(client_id);
    return found == by_id_.end() ? nullptr : found->second;
}

Session* SessionTable::find(const ClientAddress& address) const {
    return by_address_.find(ClientAddressHash{}(address), [&](const Session& session) {
        return session.header.address == address;
    });
}

Session* SessionTable::map(Session& session, const ClientAddress& address, Instant now) {
    if (session.reachable && session.header.address == address) return nullptr;
    unmap(session);
    find_again(session);
    Session* previous = find(address);
    if (previous != nullptr) {
        unmap(*previous);
        previous->displaced_at = now;
        if (previous->header.clean) displaced_.emplace(now, previous->number);
    }
    session.header.address = address;
    by_address_.insert(ClientAddressHash{}(address), &session);
    session.reachable = true;
    return previous;
}

void SessionTable::unmap(Session& session) {
    if (!session.reachable) return;
    by_address_.erase(ClientAddressHash{}(session.header.address), &session);
    session.reachable = false;
}

void SessionTable::depart(Session& session, Instant now) {
    come_back(session);
    find_again(session);
    session.departed_at = now;
    ++departed_count_;
    if (session.header.clean) departed_.emplace(now, session.number);
}

void SessionTable::come_back(Session& session) {
    if (session.departed_at == never) return;
    --departed_count_;
    departed_.erase({session.departed_at, session.number});
    session.departed_at = never;
}

void SessionTable::find_again(Session& session) {
    displaced_.erase({session.displaced_at, session.number});
    session.displaced_at = never;
}

Session* SessionTable::departed_first() const {
    return departed_.empty() ? nullptr : at(departed_.begin()->second);
}

Session* SessionTable::displaced_first() const {
    return displaced_.empty() ? nullptr : at(displaced_.begin()->second);
}

std::vector<Session*> SessionTable::by_client_id() const {
    std::vector<Session*> all;
    all.reserve(size());
    visit([&all](Session& session) { all.push_back(&session); });
    std::ranges::sort(all, {},
                      [](const Session* s) { return std::string_view{s->header.client_id}; });
    return all;
}

}  // namespace romano::broker
