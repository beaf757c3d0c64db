#include "overlay/cluster/replication/peer_log.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

namespace romano::cluster {
namespace {

constexpr std::size_t early_events_most = 20'000;
constexpr std::size_t arrived_early_most = 20'000;

}  // namespace

PeerLog::PeerLog(LogId id, std::size_t events_kept) : mirror_(id), history_(events_kept) {}

void PeerLog::offer(Seq first_seq, const std::vector<LogEventPtr>& events) {
    if (events.empty() || first_seq == 0) return;
    const Seq last = first_seq + events.size() - 1;
    known_end_ = std::max(known_end_, last);
    if (is_beyond_agreed_end(last)) return;
    if (first_seq > received() + 1) {
        if (early_events_ + events.size() > early_events_most || early_.contains(first_seq)) return;
        early_events_ += events.size();
        early_.emplace(first_seq, events);
        return;
    }
    take(first_seq, events);
    take_early();
}

bool PeerLog::is_beyond_agreed_end(Seq seq) const {
    const auto end = agreed_end();
    return end && seq > end->seq;
}

void PeerLog::take(Seq first_seq, const std::vector<LogEventPtr>& events) {
    const Seq known = received() + 1 - first_seq;  // the first ones are here already
    if (known >= events.size() || is_beyond_agreed_end(first_seq + events.size() - 1)) return;
    ready_.insert(ready_.end(), events.begin() + static_cast<std::ptrdiff_t>(known), events.end());
}

void PeerLog::take_early() {
    while (!early_.empty() && early_.begin()->first <= received() + 1) {
        const auto next = early_.extract(early_.begin());
        early_events_ -= next.mapped().size();
        take(next.key(), next.mapped());
    }
}

std::vector<MessagePtr> PeerLog::publishes_after(Seq seq) const {
    auto publishes = history_.publishes_after(seq);
    while (!publishes.empty() && publishes.back()->position.seq > end()) publishes.pop_back();
    std::ranges::copy_if(ahead_, std::back_inserter(publishes), [&](const MessagePtr& message) {
        return message->position.seq > std::max(seq, applied());
    });
    return publishes;
}

MessagePtr PeerLog::publish_at(Seq seq) const {
    if (seq <= applied()) return seq <= end() ? history_.publish_at(seq) : MessagePtr{};
    const auto found = std::ranges::lower_bound(
        ahead_, seq, {}, [](const MessagePtr& message) { return message->position.seq; });
    return found == ahead_.end() || (*found)->position.seq != seq ? MessagePtr{} : *found;
}

void PeerLog::apply() {
    const LogEvent& event = *ready_.front();
    follow_moves(event);
    mirror_.apply(applied() + 1, event);
    if (frozen_) follow_in_tail(event);
    history_.append(std::move(ready_.front()));
    ready_.pop_front();
}

/// What the dead broker still did with its sessions before it died.
void PeerLog::follow_in_tail(const LogEvent& event) {
    if (const auto* put = std::get_if<broker::SessionPut>(&event)) {
        taken_.erase(put->image.header.client_id);
    } else if (const broker::ClientId* left = broker::leaver(event)) {
        taken_.erase(*left);
    }
}

void PeerLog::follow_moves(const LogEvent& event) {
    const Seq seq = applied() + 1;
    if (const auto* put = std::get_if<broker::SessionPut>(&event)) {
        moved_.erase(put->image.header.client_id);
    } else if (const auto* moved = std::get_if<broker::SessionMoved>(&event)) {
        if (arrived_early_.erase(seq) != 0) return;
        auto image = mirror_.image(moved->header.client_id);
        if (!image) return;
        image->header = moved->header;
        moved_.insert_or_assign(moved->header.client_id,
                                MovedSession{*std::move(image), moved->to, seq});
    }
}

const MovedSession* PeerLog::moved(const broker::ClientId& client, Seq at) const {
    const auto found = moved_.find(client);
    return found == moved_.end() || found->second.at != at ? nullptr : &found->second;
}

void PeerLog::on_arrived(const broker::ClientId& client, Seq at) {
    if (at > applied() && arrived_early_.size() < arrived_early_most) arrived_early_.insert(at);
    if (moved(client, at) != nullptr) moved_.erase(client);
}

void PeerLog::forget_moved() {
    std::erase_if(moved_, [this](const auto& entry) { return entry.second.at <= moved_before_; });
    moved_before_ = frozen_ ? 0 : applied();
}

bool PeerLog::call_back(const View& view, const PeerLogs& logs) {
    bool is_known = true;
    called_back_.clear();
    for (const auto& [client, session] : moved_) {
        if (view.contains(session.to)) continue;
        const auto to = logs.find(session.to);
        const bool may_arrive = to != logs.end() && !to->second.has_agreed_end();
        if (may_arrive) {
            is_known = false;
        } else {
            called_back_.insert(client);
        }
    }
    return is_known;
}

void PeerLog::offer_ahead(const std::vector<MessagePtr>& publishes) {
    std::ranges::copy_if(publishes, std::back_inserter(ahead_), [this](const MessagePtr& message) {
        return message->position.seq > (ahead_.empty() ? applied() : ahead_.back()->position.seq);
    });
}

bool PeerLog::offer(const SnapshotPart& part) {
    if (part.part == 0) snapshot_.emplace(part);
    if (!snapshot_ || snapshot_->since != part.since || snapshot_->next_part != part.part) {
        snapshot_.reset();  // parts are lost: the gap remains and is asked for again
        return false;
    }
    offer_ahead(part.publishes);
    ++snapshot_->next_part;
    snapshot_->replaced.clear();
    const auto note_replaced = [this](const broker::ClientId& client) {
        const auto* earlier = snapshot_->sessions.session(client);
        if (earlier != nullptr) snapshot_->replaced.push_back(*earlier);
    };
    for (const auto& image : part.sessions) {
        note_replaced(image.header.client_id);
        snapshot_->sessions.put(image);
        snapshot_->moved.erase(image.header.client_id);
    }
    for (const auto& client : part.gone) {
        note_replaced(client);
        snapshot_->sessions.erase(client);
        snapshot_->moved.erase(client);
    }
    for (const auto& session : part.moved) {
        snapshot_->moved.insert_or_assign(session.image.header.client_id, session);
    }
    auto& publishes = snapshot_->publishes;
    publishes.insert(publishes.end(), part.publishes.begin(), part.publishes.end());
    if (part.last) {
        snapshot_->as_of = part.as_of.seq;
        snapshot_->sessions.begin_after(part.as_of.seq, part.cursors);
    }
    return true;
}

std::optional<LogPosition> PeerLog::restart() {
    if (!snapshot_ || !snapshot_->as_of) return std::nullopt;
    Snapshot snapshot = *std::exchange(snapshot_, std::nullopt);
    const Seq as_of = *snapshot.as_of;
    const Seq covered = std::min(received(), as_of) - applied();
    ready_.erase(ready_.begin(), ready_.begin() + static_cast<std::ptrdiff_t>(covered));
    std::erase_if(snapshot.moved, [this](const auto& entry) {
        const auto& [client, session] = entry;
        return session.at <= applied() ? moved(client, session.at) == nullptr
                                       : arrived_early_.contains(session.at);
    });
    moved_ = std::move(snapshot.moved);
    mirror_ = std::move(snapshot.sessions);
    history_.restart(as_of, std::move(snapshot.publishes));
    ahead_.clear();
    std::erase_if(arrived_early_, [as_of](Seq seq) { return seq <= as_of; });
    known_end_ = std::max(known_end_, as_of);
    take_early();
    return LogPosition{mirror_.log(), as_of};
}

void PeerLog::freeze() {
    if (frozen_) return;
    frozen_ = true;
    moved_before_ = 0;  // who is dead takes nothing back
    ready_.clear();     // acknowledged to nobody, and perhaps beyond what the members agree on
    early_.clear();
    early_events_ = 0;
    snapshot_.reset();
}

void PeerLog::heard_end(Seq last, const ViewNumber& view) {
    known_end_ = std::max(known_end_, last);
    lived_on_ |= frozen_ && agreed_end_ != 0 && last > agreed_end_ && view > ended_in_;
}

void PeerLog::end_at(Seq end, const ViewNumber& view) {
    if (lived_on_ && end > agreed_end_) taken_.clear();
    lived_on_ = false;
    if (std::exchange(agreed_end_, end) != end) ended_in_ = view;
}

void PeerLog::thaw() {
    outdated_ = false;
    if (!frozen_) return;
    frozen_ = false;
    agreed_end_ = 0;
    lived_on_ = false;
    taken_.clear();
    called_back_.clear();
}

template <typename Look>
void PeerLog::visit_left(Look&& look) const {
    if (!frozen_) return;
    mirror_.visit([&](const broker::SessionImage& image) {
        if (taken_.empty() || !taken_.contains(image.header.client_id)) look(image);
    });
    for (const auto& client : called_back_) {
        const auto session = moved_.find(client);
        if (session != moved_.end()) look(session->second.image);
    }
}

std::vector<broker::ClientId> PeerLog::clients_left(const Endpoint& address) const {
    std::vector<broker::ClientId> clients;
    visit_left([&](const broker::SessionImage& image) {
        if (image.header.via == address) clients.push_back(image.header.client_id);
    });
    return clients;
}

std::optional<broker::SessionImage> PeerLog::session_left(const broker::ClientId& client) const {
    if (!frozen_) return std::nullopt;
    const auto session = moved_.find(client);
    if (session != moved_.end() && called_back_.contains(client)) return session->second.image;
    return taken_.contains(client) ? std::nullopt : mirror_.image(client);
}

std::vector<Endpoint> PeerLog::addresses_left(const View& view) const {
    std::set<Endpoint> addresses{serving_.begin(), serving_.end()};
    for (const auto& [client, session] : moved_) {
        if (frozen_ && !view.contains(session.to)) addresses.insert(session.image.header.via);
    }
    const Endpoint* last = nullptr;  // most sessions have the same
    visit_left([&](const broker::SessionImage& image) {
        if (last == nullptr || *last != image.header.via) addresses.insert(image.header.via);
        last = &image.header.via;
    });
    return {addresses.begin(), addresses.end()};
}

}  // namespace romano::cluster
