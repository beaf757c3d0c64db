#include "overlay/cluster/replication/peer_log.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

namespace romano::cluster {
namespace {

constexpr std::size_t early_events_most = 20'000;

}  // namespace

PeerLog::PeerLog(LogId id, std::size_t events_kept) : id_(id), mirror_(id), history_(events_kept) {}

void PeerLog::offer(Seq first_seq, std::vector<LogEvent> events) {
    if (events.empty() || first_seq == 0) return;
    known_end_ = std::max(known_end_, first_seq + events.size() - 1);
    const Seq expected = received() + 1;
    if (first_seq > expected) {
        if (early_events_ + events.size() > early_events_most || early_.contains(first_seq)) return;
        early_events_ += events.size();
        early_.emplace(first_seq, std::move(events));
        return;
    }
    const Seq known = expected - first_seq;  // the first ones are here already
    if (known >= events.size()) return;
    ready_.insert(ready_.end(),
                  std::make_move_iterator(events.begin() + static_cast<std::ptrdiff_t>(known)),
                  std::make_move_iterator(events.end()));
    if (const auto next = early_.begin(); next != early_.end() && next->first <= received() + 1) {
        auto follows = early_.extract(next);
        early_events_ -= follows.mapped().size();
        offer(follows.key(), std::move(follows.mapped()));
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

const LogEvent* PeerLog::next() const {
    return ready_.empty() ? nullptr : &ready_.front();
}

void PeerLog::apply() {
    mirror_.apply(applied() + 1, ready_.front());
    if (frozen_) follow_in_tail(ready_.front());
    history_.append(std::move(ready_.front()));
    ready_.pop_front();
}

/// What the dead broker still did with its sessions before it died.
void PeerLog::follow_in_tail(const LogEvent& event) {
    if (const auto* put = std::get_if<broker::SessionPut>(&event)) {
        taken_.erase(put->image.header.client_id);
    } else if (const auto* erased = std::get_if<broker::SessionErased>(&event)) {
        taken_.erase(erased->client_id);
    }
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
    for (const auto& image : part.sessions) snapshot_->sessions.put(image);
    for (const auto& client : part.gone) snapshot_->sessions.erase(client);
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
    mirror_ = std::move(snapshot.sessions);
    history_.restart(as_of, std::move(snapshot.publishes));
    ahead_.clear();
    known_end_ = std::max(known_end_, as_of);
    while (!early_.empty()) {
        auto next = early_.extract(early_.begin());
        early_events_ -= next.mapped().size();
        const bool follows = next.key() <= received() + 1;
        offer(next.key(), std::move(next.mapped()));
        if (!follows) break;
    }
    return LogPosition{id_, as_of};
}

void PeerLog::freeze() {
    if (frozen_) return;
    frozen_ = true;
    ready_.clear();  // acknowledged to nobody, and perhaps beyond what the members agree on
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
}

template <typename Look>
void PeerLog::visit_left(Look&& look) const {
    if (!frozen_) return;
    mirror_.visit([&](const broker::SessionImage& image) {
        if (taken_.empty() || !taken_.contains(image.header.client_id)) look(image);
    });
}

std::vector<broker::SessionImage> PeerLog::sessions_left(const Endpoint& address,
                                                         std::size_t most) const {
    std::vector<broker::ClientId> clients;
    visit_left([&](const broker::SessionImage& image) {
        if (clients.size() < most && image.header.via == address) {
            clients.push_back(image.header.client_id);
        }
    });
    std::vector<broker::SessionImage> images;
    images.reserve(clients.size());
    for (const auto& client : clients) images.push_back(*mirror_.image(client));
    return images;
}

std::size_t PeerLog::count_left(const Endpoint& address) const {
    std::size_t count = 0;
    visit_left([&](const broker::SessionImage& image) {
        if (image.header.via == address) ++count;
    });
    return count;
}

std::vector<Endpoint> PeerLog::addresses_left() const {
    std::set<Endpoint> addresses{serving_.begin(), serving_.end()};
    const Endpoint* last = nullptr;  // most sessions have the same
    visit_left([&](const broker::SessionImage& image) {
        if (last == nullptr || *last != image.header.via) addresses.insert(image.header.via);
        last = &image.header.via;
    });
    return {addresses.begin(), addresses.end()};
}

}  // namespace romano::cluster
