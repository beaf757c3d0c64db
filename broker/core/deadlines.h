// Who must be looked at next: one deadline a session, in a heap that knows where each one stands.
//
// A deadline that moves later is left where it is and found out when it comes: each datagram moves
// a keep-alive, and must cost nothing here. So a due session may turn out to have nothing to do.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "romano/base/time.h"

namespace romano::broker {

class Deadlines {
public:
    using Number = std::uint32_t;

    /// Makes the deadline of `number` no later than `at`.
    void no_later_than(Number number, Instant at) {
        if (at == never) return;
        if (number >= place_.size()) place_.resize(number + 1, nowhere);
        const std::size_t place = place_[number];
        if (place == nowhere) {
            heap_.push_back({at, number});
            sift_up(heap_.size() - 1);
        } else if (at < heap_[place].at) {
            heap_[place].at = at;
            sift_up(place);
        }
    }

    void remove(Number number) {
        if (number >= place_.size() || place_[number] == nowhere) return;
        const std::size_t place = place_[number];
        place_[number] = nowhere;
        const Entry last = heap_.back();
        heap_.pop_back();
        if (place == heap_.size()) return;
        heap_[place] = last;
        sift_down(place);
        sift_up(place);
    }

    [[nodiscard]] Instant next() const { return heap_.empty() ? never : heap_.front().at; }

    /// Takes the first one out, whose deadline is next().
    Number pop() {
        const Number number = heap_.front().number;
        remove(number);
        return number;
    }

    [[nodiscard]] std::size_t size() const { return heap_.size(); }

private:
    struct Entry {
        Instant at;
        Number number;
        friend bool operator<(const Entry& a, const Entry& b) {
            return a.at != b.at ? a.at < b.at : a.number < b.number;
        }
    };
    static constexpr std::size_t nowhere = std::numeric_limits<std::size_t>::max();

    void put(std::size_t place, const Entry& entry) {
        heap_[place] = entry;
        place_[entry.number] = place;
    }

    void sift_up(std::size_t place) {
        const Entry entry = heap_[place];
        while (place > 0 && entry < heap_[(place - 1) / 2]) {
            put(place, heap_[(place - 1) / 2]);
            place = (place - 1) / 2;
        }
        put(place, entry);
    }

    void sift_down(std::size_t place) {
        const Entry entry = heap_[place];
        for (;;) {
            std::size_t child = 2 * place + 1;
            if (child >= heap_.size()) break;
            if (child + 1 < heap_.size() && heap_[child + 1] < heap_[child]) ++child;
            if (!(heap_[child] < entry)) break;
            put(place, heap_[child]);
            place = child;
        }
        put(place, entry);
    }

    std::vector<Entry> heap_;
    std::vector<std::size_t> place_;  // by number
};

}  // namespace romano::broker
