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
    by_id_.erase(session.header.client_id);
    free_.push_back(session.number);
    slots_[session.number].reset();
}

Session* SessionTable::find(std::string_view client_id) const {
    const auto found = by_id_.find(client_id);
    return found == by_id_.end() ? nullptr : found->second;
}

Session* SessionTable::find(const Origin& place) const {
    return by_address_.find(ClientAddressHash{}(place.from),
                            [&](const Session& session) { return session.is_at(place); });
}

Session* SessionTable::only_one_at(const ClientAddress& address) const {
    Session* found = nullptr;
    std::size_t count = 0;
    by_address_.visit(ClientAddressHash{}(address), [&](Session& session) {
        if (session.header.address != address || !session.is_connected()) return;
        found = &session;
        ++count;
    });
    return count == 1 ? found : nullptr;
}

bool SessionTable::has_connected_at(const ClientAddress& address) const {
    bool has = false;
    by_address_.visit(ClientAddressHash{}(address), [&](const Session& session) {
        has |= session.header.address == address && session.is_connected();
    });
    return has;
}

Session* SessionTable::map(Session& session, const Origin& place, Instant now) {
    unmap(session);
    find_again(session);
    Session* previous = find(place);
    if (previous != nullptr) displace(*previous, now);
    session.header.address = place.from;
    session.header.via = place.via;
    by_address_.insert(ClientAddressHash{}(place.from), &session);
    session.reachable = true;
    return previous;
}

void SessionTable::displace(Session& session, Instant now) {
    unmap(session);
    if (!session.is_connected()) return;
    find_again(session);
    session.header.address = without_place(session.header.address);
    session.displaced_at = now;
    if (session.header.clean) {
        displaced_.emplace(now, session.number);
    } else {
        be_absent(session, now);
    }
}

void SessionTable::unmap(Session& session) {
    if (!session.reachable) return;
    by_address_.erase(ClientAddressHash{}(session.header.address), &session);
    session.reachable = false;
}

void SessionTable::depart(Session& session, Instant now) {
    come_back(session);
    session.departed_at = now;
    ++departed_count_;
    if (session.header.clean) {
        departed_.emplace(now, session.number);
    } else {
        be_absent(session, now);
    }
}

void SessionTable::be_absent(const Session& session, Instant since) {
    if (!session.read_by_owner) absent_.add(session, since);
}

void SessionTable::come_back(Session& session) {
    find_again(session);
    if (session.departed_at == never) return;
    --departed_count_;
    departed_.erase({session.departed_at, session.number});
    absent_.remove(session, session.departed_at);
    session.departed_at = never;
}

void SessionTable::find_again(Session& session) {
    if (session.displaced_at == never) return;
    displaced_.erase({session.displaced_at, session.number});
    absent_.remove(session, session.displaced_at);
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
