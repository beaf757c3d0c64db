// The last message of each topic that was published with Retain [MQTT 3.1.1 3.3.1.3].
//
// Of two messages of a topic the later one counts, then the one of the higher broker id, so that
// brokers agree after a partition. In a cluster a deleted one stays for a while as a message with
// an empty payload: a peer that missed the deletion must not bring the message back.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "broker/core/message.h"
#include "romano/mqttsn/topic.h"

namespace romano::broker {

class RetainedStore {
public:
    RetainedStore(std::size_t most, bool keeps_deletions)
        : most_(most), keeps_deletions_(keeps_deletions) {}

    /// True when a message for this topic can be taken in.
    [[nodiscard]] bool has_room(std::string_view topic) const {
        return messages_.size() < most_ || messages_.find(topic) != messages_.end();
    }

    /// Keeps `message`, or deletes by it, unless what is there is later. False: nothing changed.
    bool put(const MessagePtr& message);

    [[nodiscard]] MessagePtr find(const LogPosition& position) const {
        const auto found = by_position_.find(position);
        return found == by_position_.end() ? MessagePtr{} : found->second;
    }

    /// Calls visit(message) for each topic behind `after` that matches, by topic, as long as it
    /// returns true; false when it did not. Deletions are not visited.
    template <typename Visitor>
    bool match(std::string_view filter, Visitor&& visit, std::string_view after = {}) const {
        const std::string_view prefix = literal_prefix(filter);
        auto at = after < prefix ? messages_.lower_bound(prefix) : messages_.upper_bound(after);
        for (; at != messages_.end() && at->first.starts_with(prefix); ++at) {
            if (prefix == filter && at->first != filter) break;
            if (at->second->payload.empty() || !mqttsn::matches(filter, at->first)) continue;
            if (!visit(at->second)) return false;
        }
        return true;
    }

    /// By topic; deletions included, $SYS not.
    [[nodiscard]] std::vector<MessagePtr> all() const;
    [[nodiscard]] std::size_t size() const { return messages_.size(); }

    /// Forgets deletions that were published before.
    void forget_deletions(HybridTime before);
    [[nodiscard]] bool has_deletions() const { return deletions_ != 0; }

private:
    /// All names that match the filter begin so.
    static std::string_view literal_prefix(std::string_view filter) {
        const std::size_t wildcard = filter.find_first_of("+#");
        if (wildcard == std::string_view::npos) return filter;
        // "a/#" matches "a" too.
        const bool parent = filter[wildcard] == '#' && wildcard > 0;
        return filter.substr(0, parent ? wildcard - 1 : wildcard);
    }

    using Messages = std::map<std::string, MessagePtr, std::less<>>;
    void drop(Messages::iterator at);

    std::size_t most_;
    bool keeps_deletions_;
    Messages messages_;
    std::unordered_map<LogPosition, MessagePtr, LogPositionHash> by_position_;
    std::size_t deletions_ = 0;
};

}  // namespace romano::broker
