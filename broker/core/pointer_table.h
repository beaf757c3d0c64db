// A hash table of pointers to things that carry their own keys: for the two look-ups that every
// datagram makes. A look-up touches one line of the table and then the thing itself.
//
// Open addressing with linear probing; each place also holds 32 bits of the hash, so that a
// stranger's key is hardly ever compared. Never iterated: its order is nobody's business. Things
// with one hash, that differ in the rest of their keys, may be looked at together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace romano::broker {

template <typename T>
class PointerTable {
public:
    /// The thing with this hash for which is_it(thing) holds, or null.
    template <typename IsIt>
    [[nodiscard]] T* find(std::size_t hash, IsIt&& is_it) const {
        if (places_.empty()) return nullptr;
        for (std::size_t at = home(hash);; at = next(at)) {
            const Place& place = places_[at];
            if (place.thing == nullptr) return nullptr;
            if (place.tag == tag_of(hash) && is_it(*place.thing)) return place.thing;
        }
    }

    /// Shows all that have this hash, in no order.
    template <typename Look>
    void visit(std::size_t hash, Look&& look) const {
        (void)find(hash, [&look](T& thing) {
            look(thing);
            return false;
        });
    }

    /// There must be no equal one.
    void insert(std::size_t hash, T* thing) {
        if ((size_ + 1) * 3 > places_.size() * 2) grow();
        put(tag_of(hash), thing);
        ++size_;
    }

    /// The very thing that was inserted with this hash.
    void erase(std::size_t hash, const T* thing) {
        std::size_t at = home(hash);
        while (places_[at].thing != thing) at = next(at);
        // Those behind that belong further in front move up.
        for (std::size_t behind = next(at); places_[behind].thing != nullptr;
             behind = next(behind)) {
            const std::size_t wanted = home(places_[behind].tag);
            const bool may_move = ((behind - wanted) & mask()) >= ((behind - at) & mask());
            if (may_move) {
                places_[at] = places_[behind];
                at = behind;
            }
        }
        places_[at] = {};
        --size_;
    }

    [[nodiscard]] std::size_t size() const { return size_; }

private:
    struct Place {
        T* thing = nullptr;
        std::uint32_t tag = 0;
    };

    static std::uint32_t tag_of(std::size_t hash) {
        return static_cast<std::uint32_t>(hash ^ (std::uint64_t{hash} >> 32U));
    }
    [[nodiscard]] std::size_t mask() const { return places_.size() - 1; }
    [[nodiscard]] std::size_t home(std::size_t hash) const { return home(tag_of(hash)); }
    /// The tag decides the place, so that growing needs no hashes.
    [[nodiscard]] std::size_t home(std::uint32_t tag) const {
        return (tag * std::uint64_t{0x9E3779B97F4A7C15} >> 32U) & mask();
    }
    [[nodiscard]] std::size_t next(std::size_t at) const { return (at + 1) & mask(); }

    void put(std::uint32_t tag, T* thing) {
        std::size_t at = home(tag);
        while (places_[at].thing != nullptr) at = next(at);
        places_[at] = {thing, tag};
    }

    void grow() {
        std::vector<Place> old =
            std::exchange(places_, std::vector<Place>(places_.empty() ? 16 : places_.size() * 2));
        for (const Place& place : old) {
            if (place.thing != nullptr) put(place.tag, place.thing);
        }
    }

    std::vector<Place> places_;
    std::size_t size_ = 0;
};

}  // namespace romano::broker
