#include "overlay/cluster/replication/log_history.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace romano::cluster {
namespace {

bool stands_before(const MessagePtr& message, Seq seq) {
    return message->position.seq < seq;
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
    for (std::size_t gone = 0; gone < most_at_once; ++gone) {
        if (events_.empty() || last_ - events_.size() + 1 > through) return true;
        events_.pop_front();
    }
    return false;
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
    for (std::size_t gone = 0; gone < most_at_once; ++gone) {
        if (publishes_.empty() || publishes_.front()->position.seq > through) return true;
        publishes_.pop_front();
    }
    return false;
}

}  // namespace romano::cluster
