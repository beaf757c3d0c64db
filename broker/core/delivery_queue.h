// What waits for one client, in order, and which of it is worked on: the first, unless its topic
// waits for a time and the first of another topic has its turn.
//
// A vector with a moving front: a session that receives steadily allocates nothing, an empty one
// takes three words. QoS 0 messages wait here too while the client sleeps or must learn a topic id
// first; they are not part of the session's image.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <utility>
#include <vector>

#include "broker/core/session_image.h"

namespace romano::broker {

class DeliveryQueue {
public:
    [[nodiscard]] bool empty() const { return front_ == items_.size(); }
    [[nodiscard]] std::size_t size() const { return items_.size() - front_; }
    /// How many of QoS 0 there are.
    [[nodiscard]] std::size_t unlogged() const { return unlogged_; }

    [[nodiscard]] Delivery& current() {
        assert(!empty());
        return items_[front_ + current_];
    }
    void choose(std::size_t place) {
        assert(place < size());
        current_ = place;
    }
    /// Of the current one.
    [[nodiscard]] std::size_t place() const { return current_; }
    [[nodiscard]] auto begin() const {
        return items_.begin() + static_cast<std::ptrdiff_t>(front_);
    }
    [[nodiscard]] auto end() const { return items_.end(); }

    void push(Delivery delivery) {
        if (is_unlogged(delivery)) ++unlogged_;
        items_.push_back(std::move(delivery));
    }

    /// Takes the current one out; the first is the next.
    void pop() {
        assert(!empty());
        if (is_unlogged(current())) --unlogged_;
        if (const std::size_t place = std::exchange(current_, 0); place != 0) {
            items_.erase(items_.begin() + static_cast<std::ptrdiff_t>(front_ + place));
            return;
        }
        items_[front_++].message = {};
        if (front_ == items_.size()) {
            items_.clear();
            front_ = 0;
        } else if (front_ >= 64 && front_ * 2 >= items_.size()) {
            items_.erase(items_.begin(), items_.begin() + static_cast<std::ptrdiff_t>(front_));
            front_ = 0;
        }
    }

    /// False when the message is not here. Not while an exchange is open.
    bool erase(const LogPosition& position) {
        const auto found = std::find_if(begin(), end(), [&](const Delivery& delivery) {
            return delivery.position == position;
        });
        if (found == end()) return false;
        choose(static_cast<std::size_t>(found - begin()));
        pop();
        return true;
    }

    /// Drops the oldest message of QoS 0, but never the current one when that is in use; false when
    /// there is none.
    bool drop_oldest_unlogged(bool current_in_use) {
        if (unlogged_ == 0) return false;
        const std::size_t kept = current_in_use ? front_ + current_ : items_.size();
        std::size_t at = front_;
        while (at < items_.size() && (at == kept || !is_unlogged(items_[at]))) ++at;
        if (at == items_.size()) return false;
        if (at < front_ + current_) --current_;
        items_.erase(items_.begin() + static_cast<std::ptrdiff_t>(at));
        --unlogged_;
        return true;
    }

    void clear() { *this = DeliveryQueue{}; }

private:
    static bool is_unlogged(const Delivery& delivery) {
        return delivery.qos == mqttsn::Qos::at_most_once;
    }

    std::vector<Delivery> items_;
    std::size_t front_ = 0;
    std::size_t current_ = 0;  // counted from the front
    std::size_t unlogged_ = 0;
};

}  // namespace romano::broker
