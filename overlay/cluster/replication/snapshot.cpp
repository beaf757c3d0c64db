#include "overlay/cluster/replication/snapshot.h"

#include <algorithm>
#include <utility>

namespace romano::cluster {
namespace {

// Parts of a few kilobytes each with the payloads that robots send.
constexpr std::size_t sessions_per_part = 16;
constexpr std::size_t messages_per_part = 64;

}  // namespace

Snapshot::Snapshot(const broker::BrokerCore& broker, const Logs& logs, const Departures& departures)
    : log_(logs.own.id()),
      since_(logs.own.last()),
      to_send_(broker.client_ids()),
      retained_(broker.retained()) {
    for (const auto& [client, leaving] : departures.all()) to_send_.push_back(client);
}

Snapshot::Snapshot(const PeerLogs::value_type& removed, Seq after)
    : log_(removed.first), since_(removed.second.end()), published_(after) {}

void Snapshot::on_event(const broker::LogEvent& event) {
    broker::visit_changed_sessions(
        event, [this](const broker::ClientId& client) { changed_.insert(client); });
}

SnapshotPart Snapshot::next(const broker::BrokerCore& broker, const Logs& logs,
                            const Departures& departures) {
    const bool is_own = log_ == logs.own.id();
    SnapshotPart part{
        .as_of = {log_, is_own ? logs.own.last() : since_}, .since = since_, .part = next_part_++};
    const bool all_sessions = !is_own || put_sessions(broker, departures, part);
    const bool all_publishes = put_publishes(logs, part);
    const std::size_t count = std::min(messages_per_part, retained_.size() - next_retained_);
    const auto retained = retained_.begin() + static_cast<std::ptrdiff_t>(next_retained_);
    part.retained.assign(retained, retained + static_cast<std::ptrdiff_t>(count));
    next_retained_ += count;
    part.last = all_sessions && all_publishes && next_retained_ == retained_.size();
    if (!part.last || !is_own) return part;
    for (const auto& client : std::exchange(changed_, {})) {
        put_session(broker, departures, client, part);
    }
    part.cursors = broker.cursors();
    return part;
}

bool Snapshot::put_sessions(const broker::BrokerCore& broker, const Departures& departures,
                            SnapshotPart& part) {
    for (std::size_t i = 0; i < sessions_per_part && !to_send_.empty(); ++i) {
        const broker::ClientId client = std::move(to_send_.back());
        to_send_.pop_back();
        changed_.erase(client);
        put_session(broker, departures, client, part);
    }
    if (!to_send_.empty()) return false;
    if (changed_.size() <= sessions_per_part || rounds_ == rounds_most) return true;
    ++rounds_;
    const auto again = std::exchange(changed_, {});
    to_send_.assign(again.begin(), again.end());
    return false;
}

void Snapshot::put_session(const broker::BrokerCore& broker, const Departures& departures,
                           const broker::ClientId& client, SnapshotPart& part) {
    if (auto image = broker.image(client)) {
        part.sessions.push_back(*std::move(image));
        return;
    }
    part.gone.push_back(client);
    const auto leaving = departures.all().find(client);
    if (leaving != departures.all().end()) part.moved.push_back(leaving->second.session);
}

bool Snapshot::put_publishes(const Logs& logs, SnapshotPart& part) {
    const LogHistory* history = logs.history_of(log_);
    if (history == nullptr) return true;
    part.publishes = history->publishes_after(published_, messages_per_part);
    while (!part.publishes.empty() && part.publishes.back()->position.seq > part.as_of.seq) {
        part.publishes.pop_back();
    }
    if (!part.publishes.empty()) published_ = part.publishes.back()->position.seq;
    return part.publishes.size() < messages_per_part;
}

}  // namespace romano::cluster
