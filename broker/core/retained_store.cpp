#include "broker/core/retained_store.h"

#include <utility>

namespace romano::broker {
namespace {

bool is_later(const Message& a, const Message& b) {
    return std::pair{a.published_at, a.position.log.broker} >=
           std::pair{b.published_at, b.position.log.broker};
}

}  // namespace

bool RetainedStore::put(const MessagePtr& message) {
    const bool deletes = message->payload.empty();
    const auto at = messages_.find(message->topic);
    const bool replaces = at != messages_.end();
    if (replaces) {
        if (!is_later(*message, *at->second)) return false;
        drop(at);
    }
    if (deletes && !keeps_deletions_) return replaces;
    if (messages_.size() >= most_) return false;
    messages_.emplace(message->topic, message);
    if (message->position.seq != 0) by_position_.emplace(message->position, message);
    if (deletes) ++deletions_;
    return true;
}

void RetainedStore::drop(Messages::iterator at) {
    by_position_.erase(at->second->position);
    if (at->second->payload.empty()) --deletions_;
    messages_.erase(at);
}

std::vector<MessagePtr> RetainedStore::all() const {
    std::vector<MessagePtr> found;
    found.reserve(messages_.size());
    for (const auto& [topic, message] : messages_) {
        if (!topic.starts_with("$SYS/")) found.push_back(message);
    }
    return found;
}

void RetainedStore::forget_deletions(HybridTime before) {
    if (deletions_ == 0) return;
    for (auto at = messages_.begin(); at != messages_.end();) {
        const auto current = at++;
        const Message& message = *current->second;
        if (message.payload.empty() && message.published_at < before) drop(current);
    }
}

}  // namespace romano::broker
