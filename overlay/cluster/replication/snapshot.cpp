#include "overlay/cluster/replication/snapshot.h"

#include <algorithm>
#include <iterator>

namespace romano::cluster {
namespace {

// Parts of a few kilobytes each with the payloads that robots send.
constexpr std::size_t sessions_per_part = 16;
constexpr std::size_t messages_per_part = 64;

/// Moves up to `most` items from `next` on; true when none is left.
template <typename Item>
bool take(std::vector<Item>& from, std::size_t& next, std::size_t most, std::vector<Item>& to) {
    const std::size_t end = std::min(next + most, from.size());
    const auto begin = from.begin();
    to.assign(std::make_move_iterator(begin + static_cast<std::ptrdiff_t>(next)),
              std::make_move_iterator(begin + static_cast<std::ptrdiff_t>(end)));
    next = end;
    return next == from.size();
}

}  // namespace

Snapshot::Snapshot(const broker::BrokerCore& broker, const Logs& logs)
    : as_of_{logs.own.id(), logs.own.last()},
      sessions_(broker.images()),
      retained_(broker.retained()),
      cursors_(broker.cursors()),
      published_(0) {}

Snapshot::Snapshot(const PeerLogs::value_type& removed, Seq after)
    : as_of_{removed.first, removed.second.end()}, published_(after) {}

SnapshotPart Snapshot::next(const Logs& logs) {
    SnapshotPart part{.as_of = as_of_, .part = next_part_++};
    const bool all_sessions = take(sessions_, next_session_, sessions_per_part, part.sessions);
    const bool all_retained = take(retained_, next_retained_, messages_per_part, part.retained);
    if (const LogHistory* history = logs.history_of(as_of_.log)) {
        part.publishes = history->publishes_after(published_, messages_per_part);
    }
    while (!part.publishes.empty() && part.publishes.back()->position.seq > as_of_.seq) {
        part.publishes.pop_back();
    }
    if (!part.publishes.empty()) published_ = part.publishes.back()->position.seq;
    const bool all_publishes = part.publishes.size() < messages_per_part;
    part.last = all_sessions && all_retained && all_publishes;
    if (part.last) part.cursors = cursors_;
    return part;
}

}  // namespace romano::cluster
