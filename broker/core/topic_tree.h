// Who subscribed to what: topic filter → subscribers, and all that match a topic name.
//
// Filters without a wildcard stand in one hash table, so that a plain match costs one look-up
// however many topics there are; those with wildcards form a tree by level. The matching rules are
// MQTT's [MQTT 3.1.1 4.7]. Visits come in a fixed order: the plain filter first, then the tree from
// its root; within one filter by subscriber. Filters and names must be valid (mqttsn/topic.h).
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "broker/core/pointer_table.h"

namespace romano::broker {

/// For a tree whose subscribers have nothing to remember about their subscription.
struct NoGrant {};

/// `Subscriber` is a small ordered key; `Grant` is what it was granted.
template <typename Subscriber, typename Grant = NoGrant>
class TopicTree {
public:
    /// Adds the subscription, or replaces the grant of the one that is there.
    void put(std::string_view filter, const Subscriber& subscriber, Grant grant = {}) {
        Entries& entries = is_plain(filter) ? plain_entries(filter) : tree_entries(filter);
        const auto at = lower_bound(entries, subscriber);
        if (at != entries.end() && at->subscriber == subscriber) {
            at->grant = std::move(grant);
            return;
        }
        entries.insert(at, Entry{subscriber, std::move(grant)});
        ++size_;
    }

    /// False when there was no such subscription.
    bool remove(std::string_view filter, const Subscriber& subscriber) {
        if (is_plain(filter)) {
            Plain* plain = find_plain(filter);
            if (plain == nullptr || !erase_from(plain->entries, subscriber)) return false;
            if (plain->entries.empty()) forget(*plain);
            return true;
        }
        return remove_below(root_, filter, subscriber);
    }

    /// The subscriber is nowhere any more. Looks at everybody's subscriptions.
    void remove_all(const Subscriber& subscriber) {
        (void)remove_some(subscriber, plains_.size(), plains_.size());
    }

    /// The same in pieces, for a subscriber who subscribes to nothing meanwhile: looks at the last
    /// `most` filters without a wildcard of the first `left`, and returns how many of these are
    /// left; with the last of them go those that have one.
    std::size_t remove_some(const Subscriber& subscriber, std::size_t left, std::size_t most) {
        left = std::min(left, plains_.size());
        for (; most > 0 && left > 0; --most) {
            Plain& plain = *plains_[--left];
            // The last one takes its place, which was looked at, or is new.
            if (erase_from(plain.entries, subscriber) && plain.entries.empty()) forget(plain);
        }
        if (left == 0) remove_all_below(root_, subscriber);
        return left;
    }

    /// The grant of exactly this filter (compared as text), or null.
    [[nodiscard]] Grant* find(std::string_view filter, const Subscriber& subscriber) {
        Entries* entries = nullptr;
        if (is_plain(filter)) {
            if (Plain* plain = find_plain(filter)) entries = &plain->entries;
        } else if (Level* level = find_level(filter)) {
            entries = ends_open(filter) ? &level->open : &level->here;
        }
        if (entries == nullptr) return nullptr;
        const auto at = lower_bound(*entries, subscriber);
        return at != entries->end() && at->subscriber == subscriber ? &at->grant : nullptr;
    }

    /// Calls visit(subscriber, grant) once for every matching subscription: a subscriber with
    /// overlapping filters is visited more than once.
    template <typename Visitor>
    void match(std::string_view name, Visitor&& visit) const {
        if (const Plain* plain = find_plain(name)) visit_all(plain->entries, visit);
        if (root_.is_bare()) return;
        const bool hidden = name.starts_with('$');  // from filters that begin with a wildcard
        match_below(root_, name, hidden, visit);
    }

    /// True when somebody's filter matches.
    [[nodiscard]] bool matches(std::string_view name) const {
        bool found = false;
        match(name, [&found](const Subscriber&, const Grant&) { found = true; });
        return found;
    }

    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] bool empty() const { return size_ == 0; }

private:
    struct Entry {
        Subscriber subscriber;
        [[no_unique_address]] Grant grant;
    };
    using Entries = std::vector<Entry>;  // sorted by subscriber

    /// A filter without wildcards.
    struct Plain {
        Entries entries;
        std::string filter;
        std::size_t place;  // in plains_
    };

    struct TextHash {
        using is_transparent = void;
        std::size_t operator()(std::string_view text) const {
            return std::hash<std::string_view>{}(text);
        }
    };

    struct Level;
    using Children =
        std::unordered_map<std::string, std::unique_ptr<Level>, TextHash, std::equal_to<>>;
    struct Level {
        Entries here;  // filters that end at this level
        Entries open;  // filters that go on with '#'
        Children children;
        std::unique_ptr<Level> any;  // the level '+'

        [[nodiscard]] bool is_bare() const {
            return here.empty() && open.empty() && children.empty() && any == nullptr;
        }
    };

    static bool is_plain(std::string_view filter) {
        return filter.find_first_of("+#") == std::string_view::npos;
    }
    static bool ends_open(std::string_view filter) { return filter.ends_with('#'); }

    /// Cuts the first level off; `last` says that none follows.
    static std::string_view take_level(std::string_view& rest, bool& last) {
        const std::size_t slash = rest.find('/');
        last = slash == std::string_view::npos;
        const std::string_view level = rest.substr(0, slash);
        rest = last ? std::string_view{} : rest.substr(slash + 1);
        return level;
    }

    static auto lower_bound(Entries& entries, const Subscriber& subscriber) {
        // Subscribers mostly come in order: look at the end first.
        if (entries.empty() || entries.back().subscriber < subscriber) return entries.end();
        return std::lower_bound(
            entries.begin(), entries.end(), subscriber,
            [](const Entry& e, const Subscriber& s) { return e.subscriber < s; });
    }

    bool erase_from(Entries& entries, const Subscriber& subscriber) {
        const auto at = lower_bound(entries, subscriber);
        if (at == entries.end() || !(at->subscriber == subscriber)) return false;
        entries.erase(at);
        --size_;
        return true;
    }

    Plain* find_plain(std::string_view filter) const {
        return plain_.find(TextHash{}(filter),
                           [filter](const Plain& plain) { return plain.filter == filter; });
    }

    Entries& plain_entries(std::string_view filter) {
        if (Plain* plain = find_plain(filter)) return plain->entries;
        plains_.push_back(std::make_unique<Plain>(Plain{{}, std::string{filter}, plains_.size()}));
        plain_.insert(TextHash{}(filter), plains_.back().get());
        return plains_.back()->entries;
    }

    void forget(Plain& plain) {
        plain_.erase(TextHash{}(plain.filter), &plain);
        const std::size_t place = plain.place;
        std::swap(plains_[place], plains_.back());
        plains_[place]->place = place;
        plains_.pop_back();
    }

    Entries& tree_entries(std::string_view filter) {
        Level* level = &root_;
        for (bool last = false; !last;) {
            const std::string_view name = take_level(filter, last);
            if (name == "#") return level->open;
            std::unique_ptr<Level>& next =
                name == "+" ? level->any
                            : level->children.try_emplace(std::string{name}).first->second;
            if (next == nullptr) next = std::make_unique<Level>();
            level = next.get();
        }
        return level->here;
    }

    Level* find_level(std::string_view filter) {
        Level* level = &root_;
        for (bool last = false; !last;) {
            const std::string_view name = take_level(filter, last);
            if (name == "#") return level;
            level = child_of(*level, name);
            if (level == nullptr) return nullptr;
        }
        return level;
    }

    static Level* child_of(const Level& level, std::string_view name) {
        if (name == "+") return level.any.get();
        const auto found = level.children.find(name);
        return found == level.children.end() ? nullptr : found->second.get();
    }

    /// Removes the subscription and the levels that become bare by it.
    bool remove_below(Level& level, std::string_view filter, const Subscriber& subscriber) {
        bool last = false;
        const std::string_view name = take_level(filter, last);
        if (name == "#") return erase_from(level.open, subscriber);
        Level* child = child_of(level, name);
        if (child == nullptr) return false;
        const bool removed =
            last ? erase_from(child->here, subscriber) : remove_below(*child, filter, subscriber);
        if (child->is_bare()) {
            if (name == "+") {
                level.any.reset();
            } else {
                level.children.erase(level.children.find(name));
            }
        }
        return removed;
    }

    void remove_all_below(Level& level, const Subscriber& subscriber) {
        erase_from(level.here, subscriber);
        erase_from(level.open, subscriber);
        std::erase_if(level.children, [&](const auto& child) {
            remove_all_below(*child.second, subscriber);
            return child.second->is_bare();
        });
        if (level.any == nullptr) return;
        remove_all_below(*level.any, subscriber);
        if (level.any->is_bare()) level.any.reset();
    }

    template <typename Visitor>
    static void visit_all(const Entries& entries, Visitor& visit) {
        for (const Entry& entry : entries) visit(entry.subscriber, entry.grant);
    }

    template <typename Visitor>
    static void match_below(const Level& level, std::string_view rest, bool hidden,
                            Visitor& visit) {
        if (!hidden) visit_all(level.open, visit);
        bool last = false;
        const std::string_view name = take_level(rest, last);
        const auto descend = [&](const Level& next) {
            if (last) {
                visit_all(next.here, visit);
                visit_all(next.open, visit);  // "a/#" matches "a"
            } else {
                match_below(next, rest, false, visit);
            }
        };
        if (const auto found = level.children.find(name); found != level.children.end()) {
            descend(*found->second);
        }
        if (level.any != nullptr && !hidden) descend(*level.any);
    }

    std::vector<std::unique_ptr<Plain>> plains_;
    PointerTable<Plain> plain_;  // by filter
    Level root_;
    std::size_t size_ = 0;
};

}  // namespace romano::broker
