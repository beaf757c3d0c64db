// A map whose entries stand in one sorted vector: where each of some dozens of entries is looked up
// all the time and few come or go, a look-up touches two or three cache lines, and not one a level
// of a tree.
//
// Named and ordered like std::map. Iterators and references last until an entry comes or goes.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <utility>
#include <vector>

namespace romano {

template <typename Key, typename Value>
class FlatMap {
public:
    using value_type = std::pair<Key, Value>;
    using iterator = typename std::vector<value_type>::iterator;
    using const_iterator = typename std::vector<value_type>::const_iterator;

    [[nodiscard]] iterator begin() { return entries_.begin(); }
    [[nodiscard]] iterator end() { return entries_.end(); }
    [[nodiscard]] const_iterator begin() const { return entries_.begin(); }
    [[nodiscard]] const_iterator end() const { return entries_.end(); }
    [[nodiscard]] auto rbegin() const { return entries_.rbegin(); }
    [[nodiscard]] auto rend() const { return entries_.rend(); }
    [[nodiscard]] bool empty() const { return entries_.empty(); }
    [[nodiscard]] std::size_t size() const { return entries_.size(); }

    [[nodiscard]] iterator find(const Key& key) {
        const auto at = place_of(entries_, key);
        return at != entries_.end() && at->first == key ? at : entries_.end();
    }
    [[nodiscard]] const_iterator find(const Key& key) const {
        const auto at = place_of(entries_, key);
        return at != entries_.end() && at->first == key ? at : entries_.end();
    }
    [[nodiscard]] bool contains(const Key& key) const { return find(key) != end(); }
    /// It is there.
    [[nodiscard]] const Value& at(const Key& key) const {
        const auto found = find(key);
        assert(found != end());
        return found->second;
    }

    /// The entry, and whether it is a new one, made of `value`.
    template <typename... Parts>
    std::pair<iterator, bool> try_emplace(const Key& key, Parts&&... value) {
        const auto at = place_of(entries_, key);
        if (at != entries_.end() && at->first == key) return {at, false};
        return {entries_.emplace(at, key, Value{std::forward<Parts>(value)...}), true};
    }
    Value& operator[](const Key& key) { return try_emplace(key).first->second; }
    void insert_or_assign(const Key& key, Value value) { (*this)[key] = std::move(value); }

    /// How many there were.
    std::size_t erase(const Key& key) {
        const auto at = find(key);
        if (at == end()) return 0;
        entries_.erase(at);
        return 1;
    }
    template <typename Predicate>
    friend std::size_t erase_if(FlatMap& map, Predicate&& is_to_go) {
        return std::erase_if(map.entries_, std::forward<Predicate>(is_to_go));
    }
    void clear() { entries_.clear(); }

private:
    template <typename Entries>
    static auto place_of(Entries& entries, const Key& key) {
        return std::ranges::lower_bound(entries, key, {}, &value_type::first);
    }

    std::vector<value_type> entries_;
};

}  // namespace romano
