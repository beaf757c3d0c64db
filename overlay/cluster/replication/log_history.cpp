#include "overlay/cluster/replication/log_history.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace romano::cluster {
namespace {

bool stands_before(const MessagePtr& message, Seq seq) {
    return message->position.seq < seq;
}

/// Of so many events of which some, or all, are due.
std::size_t piece_of(std::size_t events) {
    return std::clamp(events / 8, LogHistory::least_at_once, LogHistory::most_at_once);
}

}  // namespace

void LogHistory::append(LogEventPtr event) {
    ++last_;
    if (const auto* published = std::get_if<broker::Published>(&*event)) {
        publishes_.push_back(published->message);
        if (publishes_.size() > most_) publishes_.pop_front();
    }
    events_.push_back(std::move(event));
    if (events_.size() > most_) events_.pop_front();
}

void LogHistory::restart(Seq as_of, std::vector<MessagePtr> publishes) {
    events_.clear();
    publishes_.assign(std::make_move_iterator(publishes.begin()),
                      std::make_move_iterator(publishes.end()));
    while (publishes_.size() > most_) publishes_.pop_front();
    last_ = as_of;
}

std::vector<LogEventPtr> LogHistory::events_after(Seq seq, std::size_t most) const {
    assert(reaches_back_to(seq));
    if (seq >= last_) return {};
    const std::size_t skipped = events_.size() - static_cast<std::size_t>(last_ - seq);
    const auto from = events_.begin() + static_cast<std::ptrdiff_t>(skipped);
    const std::size_t count = std::min(most, events_.size() - skipped);
    return {from, from + static_cast<std::ptrdiff_t>(count)};
}

std::vector<MessagePtr> LogHistory::publishes_after(Seq seq, std::size_t most) const {
    const auto from =
        std::lower_bound(publishes_.begin(), publishes_.end(), seq + 1, stands_before);
    const auto there = static_cast<std::size_t>(publishes_.end() - from);
    return {from, from + static_cast<std::ptrdiff_t>(std::min(there, most))};
}

MessagePtr LogHistory::publish_at(Seq seq) const {
    const auto at = std::lower_bound(publishes_.begin(), publishes_.end(), seq, stands_before);
    return at != publishes_.end() && (*at)->position.seq == seq ? *at : MessagePtr{};
}

bool LogHistory::forget_events(Seq through) {
    const Seq first = last_ - events_.size() + 1;
    if (events_.empty() || first > through) return true;
    const std::size_t due = std::min(through, last_) - first + 1;
    const std::size_t piece = std::min(due, piece_of(due));
    events_.erase(events_.begin(), events_.begin() + static_cast<std::ptrdiff_t>(piece));
    return piece == due;
}

bool LogHistory::forget_publishes(Instant now, Duration kept_on, Seq through) {
    through = std::min(through, last_);  // nobody has passed what was not there yet
    passed_.push_back({now, through});
    while (passed_.size() > 1 && passed_[1].at + kept_on <= now) passed_.pop_front();
    if (passed_.front().at + kept_on > now) return true;
    return forget_oldest_publishes(std::min(through, passed_.front().through));
}

bool LogHistory::forget_all() {
    const bool no_event_left = forget_events(last_);
    return forget_oldest_publishes(last_) && no_event_left;
}

bool LogHistory::forget_oldest_publishes(Seq through) {
    const auto is_due = [&] {
        return !publishes_.empty() && publishes_.front()->position.seq <= through;
    };
    if (!is_due()) return true;
    std::size_t rest = piece_of(through - publishes_.front()->position.seq + 1);
    for (; rest > 0 && is_due(); --rest) publishes_.pop_front();
    return !is_due();
}

}  // namespace romano::cluster
